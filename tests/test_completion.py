"""Shell completion, with the shells themselves."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from shockwave import cli

pytest.importorskip("shtab")

#: Sources the script, types a line, and prints what the completion function offers.
TYPED = """
source "$1"
COMP_LINE="$2" COMP_POINT=${#COMP_LINE}
read -ra COMP_WORDS <<< "$COMP_LINE"
[[ "$COMP_LINE" == *" " ]] && COMP_WORDS+=("")
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
$(complete -p shockwave | sed 's/.* -F \\([^ ]*\\) .*/\\1/') shockwave "${COMP_WORDS[COMP_CWORD]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""
LINES = {
    "command": ("shockwave si", {"simulate"}),
    "option": ("shockwave simulate --int", {"--integrator"}),
    "choice": ("shockwave simulate --backend ", {"auto", "compiled", "numpy"}),
    "name": ("shockwave simulate --integrator rkn8", {"rkn86"}),
    "profile": ("shockwave new --profile tri", {"triangular"}),
    "shell": ("shockwave completion ", {"bash", "zsh", "fish"}),
    "file": ("shockwave predict mi", {"mine.yaml"}),
}


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("completion") / "shockwave.bash"
    assert cli.main(["completion", "bash", "-o", str(file)]) == 0
    return file


@pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize("name", LINES)
def test_bash_completes(name: str, script: Path, tmp_path: Path) -> None:
    line, offered = LINES[name]
    (tmp_path / "mine.yaml").touch()
    command = ["bash", "--norc", "-c", TYPED, "bash", str(script), line]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
    assert offered <= set(run.stdout.split())
    if name not in ("choice", "shell"):
        assert set(run.stdout.split()) == offered


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_parses(shell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", shell]) == 0
    text = capsys.readouterr().out
    assert "simulate" in text
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}")
    (tmp_path / "script").write_text(text, encoding="utf-8")
    subprocess.run([shell, "-n", str(tmp_path / "script")], check=True)


def test_without_shtab_its_installation_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert cli.main(["completion", "bash"]) == 2
    assert "pip install 'granular-shockwave[completion]'" in capsys.readouterr().err
