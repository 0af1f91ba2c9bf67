"""Printed output fits the screen: 80 columns without a terminal, the columns of the terminal with one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import pages
from pages import PAGES, ROOT, Block, blocks_of
from selection import keeping
from test_docs import LONG, commands

pty = pytest.importorskip("pty", reason="pseudo-terminals are a facility of POSIX")

#: Columns where there is no terminal.
PIPED = 80
#: JSON is for programs; --wide asks for all columns; validate prints one line for each error, as editors expect.
NOT_WRAPPED = re.compile(r"--json|--wide|^shockwave validate|--version")
STYLE = re.compile(r"\x1b\[[0-9;]*m")
#: A case of which prediction and simulation are quick.
SCENE = str(ROOT / "profiles" / "paper" / "table2-row1.yaml")
PROGRAM = "import sys; from shockwave.cli import main; sys.exit(main())"
#: Each prints a table that is wider than 60 columns.
COMMANDS = {
    "predict": ["predict", SCENE],
    "list": ["list", "integrators"],
    "stress": ["stress", "shocks-long-rise", "--backend", "numpy"],
}


@pytest.fixture
def patch(tmp_path: Path) -> Iterator[pytest.MonkeyPatch]:
    """A working folder, which is the current one."""
    with pages.workplace(tmp_path) as patch:
        yield patch


def too_wide(text: str, columns: int) -> list[str]:
    return [line for line in text.splitlines() if len(STYLE.sub("", line)) > columns]


CONSOLES = [block for page in PAGES for block in blocks_of(page) if block.language == "console"]


@pytest.mark.parametrize("block", keeping(CONSOLES, *(b for b in CONSOLES if b.page not in LONG)), ids=str)
def test_commands_of_the_documentation_print_at_most_80_columns(
    block: Block, tmp_path: Path, patch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pages.prepare(tmp_path, block, patch)
    for command, _ in block.commands:
        printed = pages.stdout_of(command)
        assert NOT_WRAPPED.search(command) or too_wide(printed, PIPED) == [], command


@pytest.mark.parametrize("command", ["", *commands()])
def test_help_fits_80_columns(command: str) -> None:
    assert too_wide(pages.stdout_of(f"shockwave {command} --help"), PIPED) == []
