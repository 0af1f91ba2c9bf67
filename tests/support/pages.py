"""Pages of the documentation as data: their fenced blocks, tables and links, and how blocks are run.

A comment right before a fenced block states more about it:

``<!-- file: NAME -->``
    It is also the file NAME for the commands and the code further down on its page.
``<!-- fragment: NAME -->``
    It is part of a scenario: its top-level keys take the place of those in the file NAME.
``<!-- faulty -->``
    The scenario has faults, and the page shows their messages.
``<!-- needs: PACKAGE -->``
    The code runs alone, where this package is installed, in a folder with a file that the package has written.
``<!-- table: NAME -->``, before a table
    The table is compared with the program.

In the output of commands and of ``>>>`` lines ``...`` stands for anything, as in doctest, and the last digit of a
number may differ by one: it depends on the processor. Commands and code run in a folder of their own that holds a copy
of ``profiles`` and the files of the page.
"""

import contextlib
import doctest
import glob
import importlib
import io
import re
import shlex
import shutil
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from attrs import frozen

from shockwave import cli
from support.command_line import standard_input
from support.fake_distributions import forgetting, install, on_path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted(DOCS.glob("*.md")),
    *sorted(DOCS.glob("python/*.md")),
    ROOT / "profiles" / "README.md",
    *sorted((ROOT / "plugins").glob("**/README.md")),
]
# These change what is installed, or run all tests: a test must not.
NOT_RUN = ("python -m pip ", "python3 -m venv ", ". .venv/bin/activate", "python -m pytest", "sphinx-build ", ".ci/run")

#: Columns of the output where there is no terminal.
PIPED = 80

_STYLE = re.compile(r"\x1b\[[0-9;]*m")
# A number that is no part of a word or of a version, and is not cut short by ``...``.
_NUMBER = r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w|\.\d|\.\.\.)"
# Smaller figures are rounding alone, and numbers printed with all their digits agree to this share.
_ROUNDING = 1e-13


# A fenced block, and the directives before it.
_BLOCK = re.compile(r"(?:^<!-- (.*) -->\n+)?^```(.*)\n((?:.*\n)*?)^```$", re.MULTILINE)


@frozen
class Block:
    """A fenced block: its page, the line of its fence, its language, the directives before it, its text."""

    page: Path
    line: int
    language: str
    directives: dict[str, str]
    text: str

    def __str__(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    @property
    def commands(self) -> list[tuple[str, str]]:
        """The commands of a console block, and the output that is shown for each; a backslash continues a line."""
        found = re.findall(r"^\$ ((?:.*\\\n)*.*)\n((?:(?!\$ ).*\n)*)", self.text, flags=re.MULTILINE)
        return [(re.sub(r" *\\\n *", " ", command), shown) for command, shown in found]


@cache
def blocks_of(page: Path) -> tuple[Block, ...]:
    """All fenced blocks of a page, in order."""
    text, found = page.read_text(encoding="utf-8"), []
    for match in _BLOCK.finditer(text):
        line = text.count("\n", 0, match.start(2)) + 1
        parts = (part.partition(":") for part in (match[1] or "").split(";"))
        directives = {name.strip(): value.strip() for name, _, value in parts}
        found.append(Block(page, line, match[2].strip(), directives, match[3]))
    assert 2 * len(found) == len(re.findall(r"^```", text, re.MULTILINE)), f"{page}: a fenced block is not closed"
    return tuple(found)


def prose(page: Path) -> str:
    """The text of a page without its fenced blocks."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """Anchors of the headings of a page, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ (.*)$", prose(page), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-") for heading in headings}


def table(page: str, name: str) -> list[list[str]]:
    """The cells of the table that follows ``<!-- table: name -->``, without its header."""
    text = (ROOT / page).read_text(encoding="utf-8").partition(f"<!-- table: {name} -->\n")[2]
    (lines,) = re.match(r"\n*((?:\|.*\n)+)", text).groups()  # type: ignore[union-attr]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]] for row in lines.splitlines()[2:]]


def code_in(cell: str) -> list[str]:
    """What stands between backticks in a cell."""
    return re.findall(r"`([^`]+)`", cell)


@contextlib.contextmanager
def workplace(folder: Path) -> Iterator[pytest.MonkeyPatch]:
    """Work in ``folder``, with a copy of the profiles there, and look for plugins nowhere else.

    What is imported from it is forgotten afterwards.
    """
    shutil.copytree(ROOT / "profiles", folder / "profiles")

    here = metadata.Distribution.discover
    with pytest.MonkeyPatch.context() as patch, forgetting(folder, ROOT / "plugins"):
        patch.chdir(folder)
        patch.setattr(metadata, "distributions", lambda **_: here(path=[str(folder)]))
        yield patch


def prepare(folder: Path, block: Block, patch: pytest.MonkeyPatch) -> None:
    """Put the files of the page, down to ``block``, into ``folder``; distributions among them count as installed."""
    for earlier in blocks_of(block.page):
        if earlier.line < block.line and "file" in earlier.directives:
            file = folder / earlier.directives["file"]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(earlier.text, encoding="utf-8")
    for project in (*folder.glob("*/pyproject.toml"), block.page.parent / "pyproject.toml"):
        if project.is_file() and project.parent != ROOT:
            install(folder, project, patch)
    on_path(folder, patch)
    importlib.invalidate_caches()


class _Output(io.StringIO):
    """Standard output, which is shown between the errors on ``screen``."""

    def __init__(self, screen: io.StringIO) -> None:
        super().__init__()
        self._screen = screen

    def write(self, text: str) -> int:
        self._screen.write(text)
        return super().write(text)


def run(command: str, status: int, output: io.StringIO | None = None) -> tuple[str, int]:
    """Output of ``command``, errors included, and its exit status; ``status`` is that of the last command.

    Without the errors, it is also written to ``output``.
    """
    printed = io.StringIO()
    for part in (part.strip() for part in command.split("&&")):
        if f"{part} ".startswith(NOT_RUN):
            continue
        if part == "echo $?":
            print(status, file=printed)
            continue
        *before, last = part.split(" | ")
        piped = ""
        for each in before:
            with contextlib.redirect_stderr(printed):
                piped, _ = _run(each, piped, io.StringIO())
        with contextlib.redirect_stderr(printed):
            shown, status = _run(last, piped, _Output(printed))
        if output is not None:
            output.write(shown)
    return printed.getvalue(), status


def _run(command: str, piped: str, stdout: io.StringIO) -> tuple[str, int]:
    """Output and exit status of one command of a pipe; ``piped`` is on its standard input."""
    program, *words = shlex.split(command)
    assert program == "shockwave", f"{command!r} is neither a command of shockwave nor in NOT_RUN"
    arguments = [file for word in words for file in (sorted(glob.glob(word)) if "*" in word else [word])]
    with contextlib.redirect_stdout(stdout), standard_input(piped):
        try:
            status = cli.main(arguments)
        except SystemExit as end:
            status = int(end.code or 0)
    return stdout.getvalue(), status


def widest(text: str) -> int:
    """Number of columns of the longest line, without its style."""
    return max((len(_STYLE.sub("", line)) for line in text.splitlines()), default=0)


def agree(shown: str, printed: str) -> bool:
    """Whether text that was shown is what was printed, but for last digits of numbers; ``...`` stands for anything.

    The pages show what the compiled code prints; where it was not built, the other names itself. The width of columns
    follows from the numbers in them.
    """
    # every other part is a number or an ellipsis
    parts = re.split(rf"(\.\.\.|{_NUMBER})", _normal(shown))
    numbers = [part for part in parts[1::2] if part != "..."]
    wanted = [".*?" if mark == "..." else f"({_NUMBER})" for mark in parts[1::2]]
    pattern = "".join(_to_the_letter(text) + mark for text, mark in zip(parts[::2], [*wanted, ""], strict=True))
    match = re.fullmatch(pattern, _normal(printed), flags=re.DOTALL)
    return match is not None and all(map(_is_about, numbers, match.groups()))


def _normal(text: str) -> str:
    """``text`` without the name of the backend and spaces at the ends of lines."""
    return re.sub(r" +$", "", text.replace("(numpy)", "(compiled)").rstrip(), flags=re.MULTILINE)


def _to_the_letter(text: str) -> str:
    """A pattern for ``text``, whatever the width of columns."""
    return re.sub(r"(\\-){3,}", "-{3,}", re.sub(r"(\\ ){2,}", " {2,}", re.escape(text)))


def _is_about(shown: str, printed: str) -> bool:
    """Whether two numbers are equal, or differ by one unit of a last digit; whole ones are counts."""
    if re.fullmatch(r"[-+]?\d+", shown) and re.fullmatch(r"[-+]?\d+", printed):
        return shown == printed
    one, other = float(shown), float(printed)
    # of two lengths the longer one counts: 1.0 may stand for 0.9999999999999999, but not for 0.95
    allowed = max(1.01 * min(_unit(shown), _unit(printed)), _ROUNDING * abs(one))
    return max(abs(one), abs(other)) < _ROUNDING or abs(one - other) <= allowed


def _unit(number: str) -> float:
    """One unit of the last digit."""
    digits, _, exponent = number.partition("e")
    return float(10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])))


class _Checker(doctest.OutputChecker):
    """Compares what a session prints as `agree` does."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        return agree(want.replace(doctest.BLANKLINE_MARKER, ""), got)


def execute(block: Block, names: dict[str, Any]) -> None:
    """Run a block of Python, or a session of it, with and into ``names``."""
    if block.language == "python":
        exec(compile("\n" * block.line + block.text, str(block.page), "exec"), names)
        return
    test = doctest.DocTestParser().get_doctest(block.text, names, str(block), str(block.page), block.line)
    found: list[str] = []
    doctest.DocTestRunner(_Checker(), optionflags=doctest.ELLIPSIS).run(test, out=found.append, clear_globs=False)
    names.update(test.globs)
    assert found == [], "".join(found)
