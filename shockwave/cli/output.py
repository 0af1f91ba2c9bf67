"""Output of the commands: results, files, progress and error messages, and the streams of the process."""

from __future__ import annotations

import argparse
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from shockwave.base.errors import (
    FileAccessError,
    InvalidValueError,
    ShockwaveError,
    UnknownNameError,
    UsageError,
    message_of,
)
from shockwave.base.files import write_file
from shockwave.base.progress import show_progress
from shockwave.base.quantity_fields import join

#: Environment variable that makes internal errors raise, with a traceback.
_DEBUG = "SHOCKWAVE_DEBUG"
#: Endings of files of pictures and of tables.
PICTURES = (".svg", ".png", ".pdf")
TABLES = (".csv", ".nc")
# Arguments in Python that options give one by one, and these options.
_SINGULAR = {"quantities": "quantity", "frequencies": "from"}


def failure(error: Exception) -> tuple[str, int]:
    """The message and the exit status for an error; with SHOCKWAVE_DEBUG, an internal error is raised instead."""
    if isinstance(error, ShockwaveError):
        return str(error), error.exit_code
    if os.environ.get(_DEBUG):
        raise error
    if isinstance(error, OSError):
        file = f"{error.filename}: " if error.filename else ""
        system = f"error of the operating system: {error.strerror or error}"
        return f"{file}{system} ({_DEBUG}=1 shows where)", FileAccessError.exit_code
    return f"internal error: {message_of(error)} ({_DEBUG}=1 shows where; please report it)", 1


@contextmanager
def report_as_usage(options: argparse.Namespace) -> Iterator[None]:
    """Report an invalid argument as an error of usage, not of a scenario."""
    try:
        yield
    except InvalidValueError as error:
        if not all(fault.path.partition(".")[0] in {*vars(options), *_SINGULAR} for fault in error.faults):
            raise
        named = (
            f"--{_SINGULAR.get(fault.path, fault.path.replace('_', '-'))}: {fault.problem}" for fault in error.faults
        )
        raise UsageError("\n".join(named)) from None


@contextmanager
def report_name_as_usage(option: str = "") -> Iterator[None]:
    """Report an unknown name as an error of usage, of this ``option`` if the message does not say what it names."""
    try:
        yield
    except UnknownNameError as error:
        raise UsageError(f"{option}: {error}" if option else str(error)) from None


def check_output(output: str | None, *endings: str, hint: str = "", option: str = "--output") -> None:
    """Refuse an output file with another ending, before anything is computed."""
    if output and not output.lower().endswith(endings):
        raise UsageError(f"{option}: must end in {join(endings)} (got {output}{hint})")


def json_text(document: object) -> str:
    return json.dumps(document, indent=2, allow_nan=False)


def print_result(result: Any, as_json: bool) -> None:
    text = json_text(result.to_dict()) if as_json else str(result)
    _BAR_SHOWN.close()  # computing the text may have shown progress
    print(text)


# Bar of progress with the time left, for tqdm.
_BAR = "{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} [{elapsed}<{remaining}]"


class ProgressBar:
    """A bar on stderr for work that takes longer than a second; reports of work within this work are ignored."""

    def __init__(self) -> None:
        self._work = ""
        self._bar: Any = None

    def __call__(self, work: str, done: int, total: int | None) -> None:
        if self._bar is None:
            from tqdm import tqdm

            tqdm.monitor_interval = 0  # without a thread of its own
            self._work = work
            form = _BAR if total else "{desc}: {n_fmt} steps [{elapsed}]"
            self._bar = tqdm(total=total, desc=work, delay=1, leave=False, dynamic_ncols=True, bar_format=form)
        if work != self._work:
            return
        self._bar.total = total
        self._bar.update(done - self._bar.n)
        if done == total:
            self.close()

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


_BAR_SHOWN = ProgressBar()


@contextmanager
def progress_on_stderr() -> Iterator[None]:
    """Show progress meanwhile, if stderr is a terminal."""
    with show_progress(_BAR_SHOWN if sys.stderr.isatty() else None):
        try:
            yield
        finally:
            _BAR_SHOWN.close()


@contextmanager
def announce_file(output: str | os.PathLike[str]) -> Iterator[None]:
    """State on stderr that a file was written meanwhile, and whether it replaced another."""
    state = "replaced" if os.path.exists(output) else "written"
    yield
    print(f"{output}: {state}", file=sys.stderr)


def write_result(result: Any, output: str, draw: Callable[..., Any] | None = None, size: Any = "column") -> None:
    """Write a result to a file: its main table, or its picture, by ``draw`` if it is not that of `Result.plot`."""
    with announce_file(output):
        if output.lower().endswith(TABLES):
            result.write(output)
            return
        from shockwave import pictures  # other files do not need it

        sheet, (ax,) = pictures.figure(size=size)
        (draw or result.plot)(ax=ax)
        pictures.save(sheet, output)


def write_output(text: str, output: str | None, anew: bool = False) -> int:
    """Write ``text`` to stdout, also for ``-``, or to the file ``output``, which must not exist if ``anew`` is true."""
    if output in (None, "-"):
        print(text, end="")
        return 0
    with announce_file(output):
        write_file(output, text, anew)
    return 0


# ---------------------------------------------------------------- standard streams


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
