"""The standard streams of a command, which may be closed, full or without a reader."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any

from shockwave.base.errors import FileAccessError


class OutputError(FileAccessError):
    """stdout cannot be written; the cause is the error of the operating system."""


class _Stream:
    """A stream whose errors are distinguished from those of files: they raise `OutputError`, or are ignored."""

    def __init__(self, stream: Any, required: bool) -> None:
        self._stream = stream
        self._required = required

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        self._attempt(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        self._attempt(self._stream.flush)

    def _attempt(self, action: Any, *arguments: str) -> None:
        try:
            action(*arguments)
        except OSError as error:
            with suppress(OSError):  # otherwise Python reports the same error again on exit
                os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
            if self._required:
                raise OutputError(f"the output cannot be written ({error.strerror or error})") from error


def reopen_closed_streams() -> None:
    """Replace streams that the parent process has closed by ones that cannot be written.

    Otherwise the next file that is opened would get the number of a standard stream.
    """
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            number = os.open(os.devnull, os.O_RDONLY)
            os.set_inheritable(number, True)  # the server of worker processes needs them, too
            setattr(sys, name, open(number, "r" if name == "stdin" else "w"))  # noqa: SIM115


@contextmanager
def standard_streams() -> Iterator[None]:
    """Raise `OutputError` for text that cannot be written to stdout; ignore text that cannot be written to stderr."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # characters that the terminal cannot show are no error
            stream.reconfigure(errors="backslashreplace")
    out: Any = _Stream(sys.stdout, required=True)
    err: Any = _Stream(sys.stderr, required=False)
    with redirect_stdout(out), redirect_stderr(err):
        try:
            yield
        finally:
            err.flush()  # an error on exit would change the exit status
