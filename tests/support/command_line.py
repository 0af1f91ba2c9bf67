"""Commands that run in the process of the test, and the scenarios that they read."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import pytest
from attrs import frozen

from shockwave import cli


@frozen
class Answer:
    """Exit status and output of a command."""

    status: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        """The JSON document on standard output."""
        return json.loads(self.out)


def unwrapped(text: str) -> str:
    """``text`` in one line: where the lines of a screen break depends on the paths in them."""
    return " ".join(text.split())


@contextmanager
def standard_input(text: str) -> Iterator[None]:
    """Let ``text`` be on standard input."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
        yield


def shockwave(*arguments: object, stdin: str = "") -> Answer:
    """Run ``shockwave`` with arguments, and catch the end of its process."""
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err, standard_input(stdin):
        try:
            status = cli.main([str(argument) for argument in arguments])
        except SystemExit as end:
            status = int(end.code or 0)
    return Answer(status, out.getvalue(), err.getvalue())


def scenario(folder: Path, *blocks: str, name: str = "scene") -> Path:
    """A scenario file of these blocks."""
    file = folder / f"{name}.yaml"
    file.write_text("\n".join([*blocks, ""]), encoding="utf-8")
    return file
