"""The command line. What a command needs is imported when it is run, so that help costs nothing."""

from __future__ import annotations

import importlib
import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext

from shockwave.cli.output import failure, progress_on_stderr
from shockwave.cli.parser import parser
from shockwave.errors import FileAccessError
from shockwave.text import on_stdout


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; no exception leaves it."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a name in letters that the terminal does not have is no error
            stream.reconfigure(errors="backslashreplace")
    options = parser().parse_args(arguments)
    try:
        registry = _without_plugins() if options.no_plugins else nullcontext()
        with on_stdout(options.wide), progress_on_stderr(), registry:
            module, _, name = options.command.partition(":")
            status: int = getattr(importlib.import_module(f"shockwave.cli.{module}"), name)(options)
            sys.stdout.flush()
            return status
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        # Python must not complain about the output again on exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):  # the reader has gone
            return 0
        print(f"the output cannot be written ({error.strerror or error})", file=sys.stderr)
        return FileAccessError.exit_code
    except Exception as error:
        text, status = failure(error)
        print(text, file=sys.stderr)
        return status


@contextmanager
def _without_plugins() -> Iterator[None]:
    """All plugins are disabled, here and in processes that are started meanwhile."""
    from shockwave.registry import DISABLE, EVERY, forget

    before = os.environ.get(DISABLE, "")
    os.environ[DISABLE] = EVERY
    forget()
    try:
        yield
    finally:
        os.environ[DISABLE] = before
        forget()
