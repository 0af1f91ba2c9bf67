"""Printed output fits the screen: 80 columns without a terminal, the columns of the terminal with one."""

import contextlib
import os
import re
import struct
import subprocess
import sys
import time

import pytest

from shockwave.cli.command_table import OFFERED
from shockwave.cli.output import ProgressBar
from support import pages
from support.pages import PIPED, ROOT, widest
from support.programs import commands

STYLE = re.compile(r"\x1b\[[0-9;]*m")
# A chain of many features, with several warnings.
LAYERS = str(ROOT / "profiles" / "validation" / "layers.yaml")
# Quick commands whose output has lines of more than 80 columns where there is room.
WIDE = {"compare": ["compare", LAYERS], "list": ["list", "integrators"]}
PROGRAM = "import sys; from shockwave.cli import main; sys.exit(main())"


@pytest.mark.parametrize("command", ["", *(name for name in commands() if name not in OFFERED)])
def test_help_fits_80_columns(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(PIPED))
    printed, _ = pages.run(f"shockwave {command} --help", 0)
    assert f"usage: shockwave {command}".rstrip() in printed
    assert widest(printed) <= PIPED


@pytest.mark.parametrize("options", ["", "--full", "--full --profile tabulated", "--example wall", "--example striker"])
def test_new_scenarios_have_at_most_80_columns(options: str) -> None:
    printed, _ = pages.run(f"shockwave new {options}", 0)
    assert 0 < widest(printed) <= PIPED


# ---------------------------------------------------------------- terminals


def on_a_terminal(arguments: list[str], columns: int, **environment: str) -> str:
    """Output of a command on a pseudo-terminal with this number of columns."""
    pty, termios, fcntl = (pytest.importorskip(name) for name in ("pty", "termios", "fcntl"))  # those of POSIX
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES", "NO_COLOR")}
    command = [sys.executable, "-c", PROGRAM, *arguments]
    printed = b""
    with subprocess.Popen(command, stdout=theirs, env=kept | {"TERM": "xterm"} | environment) as process:
        os.close(theirs)
        with contextlib.suppress(OSError):  # on Linux, the end of the output is an input/output error
            while part := os.read(ours, 1 << 16):
                printed += part
    os.close(ours)
    assert process.returncode == 0
    return printed.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("command", WIDE)
def test_output_on_a_terminal_uses_its_width_and_has_colour(command: str) -> None:
    broad = on_a_terminal(WIDE[command], 140)
    assert PIPED < widest(broad) <= 140
    assert STYLE.search(broad)
    assert widest(on_a_terminal(WIDE[command], 60)) <= 60


def test_no_color_turns_colour_off() -> None:
    assert not STYLE.search(on_a_terminal(WIDE["list"], 140, NO_COLOR="1"))


def test_progress_shows_the_time_left_and_is_cleared(capsys: pytest.CaptureFixture[str]) -> None:
    bar = ProgressBar()
    bar("work", 0, 4)
    bar("part of it", 1, 2)
    time.sleep(1.1)  # a bar is shown after a second
    bar("work", 3, 4)
    assert re.search(r"work:  75%.* 3/4 \[00:01<00:0\d\]", capsys.readouterr().err)
    bar.close()
    cleared = capsys.readouterr().err
    assert cleared.endswith("\r")
    assert not cleared.strip()


@pytest.mark.parametrize("command", WIDE)
def test_piped_output_has_80_columns_and_no_colour(command: str) -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM, *WIDE[command]], stdout=subprocess.PIPE, check=True)
    printed = done.stdout.decode()
    assert 60 < widest(printed) <= PIPED
    assert not STYLE.search(printed)
