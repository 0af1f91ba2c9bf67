"""The standard streams of a command, which may be closed, full or without a reader."""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress
from typing import TextIO


def reopen_closed_streams() -> None:
    """Replace streams that the parent process has closed by ones that cannot be written.

    Otherwise the next file that is opened would get the number of a standard stream.
    """
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            number = os.open(os.devnull, os.O_RDONLY)
            os.set_inheritable(number, True)  # the server of worker processes needs them, too
            setattr(sys, name, open(number, "r" if name == "stdin" else "w"))  # noqa: SIM115


def show_all_characters() -> None:
    """Print characters that the terminal cannot show as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def drop_unwritable_text(stream: TextIO) -> None:
    """Drop text that cannot be written; otherwise Python would report the error again on exit."""
    try:
        stream.flush()
    except OSError:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
