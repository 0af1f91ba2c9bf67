"""Files that anybody may have put there: regular ones only, read up to a limit, with errors in plain words."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO

from shockwave.errors import FileAccessError, InvalidValueError

__all__ = ["lines_of", "open_new", "open_regular", "parse_json", "read_bytes", "read_text"]

# Lists and mappings within each other. Whatever walks through a document may call itself so often.
_DEEPEST = 100


def open_regular(path: str | os.PathLike[str], remedy: str = "", mode: str = "rb", buffering: int = -1) -> BinaryIO:
    """Open a regular file; a pipe or a device, which may never end, is refused without waiting for it.

    Parameters
    ----------
    path : path-like
        Links are followed.
    remedy : str, optional
        What to do about a file that cannot be read, for the message.
    mode, buffering : str, int
        As for `open`; of bytes.

    Raises
    ------
    FileAccessError
        When it cannot be opened, or is no regular file; its ``__cause__`` is the OSError, if there was one.
    """
    hint = f"; {remedy}" if remedy else ""

    def opener(name: str, flags: int) -> int:
        # the other end of a pipe is not waited for; Windows has no such flag, and no such pipes
        descriptor = os.open(name, flags | getattr(os, "O_NONBLOCK", 0))
        kind = os.fstat(descriptor).st_mode
        if not stat.S_ISREG(kind):
            os.close(descriptor)
            got = "a folder" if stat.S_ISDIR(kind) else "a pipe or a device"
            raise FileAccessError(f"{os.fspath(path)}: is not a file (got {got}{hint})")
        return descriptor

    try:
        file: Any = open(path, mode, buffering, opener=opener)  # noqa: SIM115
    except IsADirectoryError as error:
        raise FileAccessError(f"{os.fspath(path)}: is not a file (got a folder{hint})") from error
    except OSError as error:
        raise _refused(path, error, hint, "read" if mode == "rb" else "written") from error
    except ValueError as error:  # a NUL character in the path
        raise FileAccessError(f"{os.fspath(path)!r}: is no path (got {error}{hint})") from None
    opened: BinaryIO = file
    return opened


def open_new(path: Path, mode: str = "xb", **text: Any) -> IO[Any]:
    """Open a new file for writing, in place of whatever has its name: a link would lead elsewhere, a pipe would wait.

    Raises
    ------
    OSError
        When that cannot be done.
    """
    path.unlink(missing_ok=True)
    return path.open(mode, **text)


def read_bytes(path: str | os.PathLike[str], limit: int, remedy: str = "") -> bytes:
    """The content of a regular file of at most ``limit`` bytes.

    Raises
    ------
    FileAccessError
        As for `open_regular`, and when the file is larger.
    """
    hint = f"; {remedy}" if remedy else ""
    with open_regular(path, remedy) as file:
        try:
            data = file.read(limit + 1)
        except OSError as error:
            raise _refused(path, error, hint) from error
    if len(data) > limit:
        raise FileAccessError(f"{os.fspath(path)}: must be at most {_size(limit)} (got more{hint})")
    return data


def read_text(path: str | os.PathLike[str], limit: int, remedy: str = "") -> str:
    """The UTF-8 text of a regular file of at most ``limit`` bytes, without a byte order mark.

    Raises
    ------
    FileAccessError
        As for `read_bytes`, and when the file is not UTF-8 text; its ``__cause__`` is then the UnicodeDecodeError.
    """
    data = read_bytes(path, limit, remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        got = f"got the byte 0x{data[error.start]:02x} in line {line}"
        raise FileAccessError(f"{os.fspath(path)}: must be UTF-8 text ({got}; save it as UTF-8)") from error


def lines_of(file: BinaryIO, name: str | os.PathLike[str], longest: int) -> Iterator[bytes]:
    """The lines of ``file``, called ``name``, with their ends; the last may have none.

    Raises
    ------
    FileAccessError
        When it cannot be read, or has a line of ``longest`` bytes or more.
    """
    try:
        while line := file.readline(longest):
            if len(line) == longest:
                raise FileAccessError(f"{os.fspath(name)}: must have lines of less than {_size(longest)} (got more)")
            yield line
    except OSError as error:
        raise _refused(name, error, "") from error


def parse_json(text: str | bytes, name: str, remedy: str = "") -> Any:
    """The value that a JSON text has.

    Parameters
    ----------
    text : str or bytes
        Bytes are UTF-8.
    name : str
        What messages call it.
    remedy : str, optional
        What to do about it, for the message.

    Raises
    ------
    InvalidValueError
        When it is not JSON, is nested too deeply, or holds NaN or an infinity, which JSON does not have.
    """
    try:
        value = json.loads(text, parse_constant=_no_constant)
        level, depth = [value], 0
        while level:
            depth += 1
            if depth > _DEEPEST:
                raise RecursionError
            inner = (one.values() if isinstance(one, dict) else one for one in level if isinstance(one, dict | list))
            level = [one for values in inner for one in values if isinstance(one, dict | list)]
        return value
    except (ValueError, RecursionError) as error:  # a UnicodeDecodeError is a ValueError
        got = "lists or mappings nested too deeply" if isinstance(error, RecursionError) else error
        hint = f"; {remedy}" if remedy else ""
        raise InvalidValueError.of(name, f"must be JSON (got {got}{hint})") from None


def _no_constant(constant: str) -> None:
    raise ValueError(f"the number {constant}")


def _refused(path: str | os.PathLike[str], error: OSError, hint: str, what: str = "read") -> FileAccessError:
    return FileAccessError(f"{os.fspath(path)}: cannot be {what} (got {error.strerror or error}{hint})")


def _size(limit: int) -> str:
    return f"{limit >> 20} MiB" if limit >= 2**20 else f"{limit} bytes"
