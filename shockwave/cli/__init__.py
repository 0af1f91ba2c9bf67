"""The command line. A command imports its modules when it runs, so that help is fast."""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress

from shockwave.base.text import Detail, on_stdout
from shockwave.cli.output import (
    drop_unwritable_text,
    failure,
    progress_on_stderr,
    reopen_closed_streams,
    show_all_characters,
)
from shockwave.cli.parser import parse

# New objects after which garbage is collected: more than a command creates at its start, nearly all of which last.
_GARBAGE = 200_000
# The threshold of the interpreter, and the modules of commands that may stay running and therefore need it.
_USUAL = gc.get_threshold()
_LASTING = ("plugin_commands", "sweep_command")
# Numbers of threads of the libraries of linear algebra, read when NumPy is loaded: matrices are small, and further
# threads would spend several times the computing time on waiting for one another.
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


def command() -> int:
    """Run the command of this process, and tune its garbage collection, which is that of no other program."""
    reopen_closed_streams()
    gc.set_threshold(_GARBAGE)
    atexit.register(gc.freeze)  # no search for garbage in a process that ends, a sixth of the time of `predict`
    return main()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; exceptions are reported, not raised."""
    for name in _THREADS:
        os.environ.setdefault(name, "1")
    show_all_characters()
    try:
        return _run(sys.argv[1:] if arguments is None else list(arguments))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except Exception as error:
        drop_unwritable_text(sys.stdout)
        if isinstance(error, BrokenPipeError):
            return 0  # the reader has closed the pipe
        text, status = failure(error)
        with suppress(OSError):
            print(text, file=sys.stderr)
        drop_unwritable_text(sys.stderr)
        return status


def _run(arguments: list[str]) -> int:
    try:
        options = parse(arguments)
        registry = _disable_plugins() if options.no_plugins else nullcontext()
        with on_stdout(getattr(options, "wide", False), detail_of(options)), progress_on_stderr(), registry:
            module, _, name = options.command.partition(":")
            if module in _LASTING and gc.get_threshold()[0] == _GARBAGE:
                gc.set_threshold(*_USUAL)
            status: int = getattr(importlib.import_module(f"shockwave.cli.{module}"), name)(options)
            return status
    finally:
        sys.stdout.flush()


def detail_of(options: Namespace) -> Detail:
    """How much of a result the options ask for."""
    verbose, explain = (getattr(options, name, False) for name in ("verbose", "explain"))
    return Detail.VERBOSE if verbose else Detail.EXPLAIN if explain else Detail.SHORT


@contextmanager
def _disable_plugins() -> Iterator[None]:
    """Disable all plugins meanwhile, here and in child processes."""
    from shockwave.registry.registry import DISABLE, EVERY, forget

    before = os.environ.get(DISABLE, "")
    os.environ[DISABLE] = EVERY
    forget()
    try:
        yield
    finally:
        os.environ[DISABLE] = before
        forget()
