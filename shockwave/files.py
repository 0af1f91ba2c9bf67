"""Reading of untrusted files: regular files only, up to a size limit, with plain error messages."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO

from shockwave.errors import FileAccessError, InvalidValueError

__all__ = ["lines_of", "open_new", "open_regular", "parse_json", "read_bytes", "read_text"]

# Deepest nesting of lists and mappings; functions that walk through a document may recurse to this depth.
_DEEPEST = 100


def open_regular(path: str | os.PathLike[str], remedy: str = "", mode: str = "rb", buffering: int = -1) -> BinaryIO:
    """Open a regular file; refuse a pipe or a device, which may never end, without waiting for it.

    Parameters
    ----------
    path : path-like
        Links are followed for reading, and refused for writing.
    remedy : str, optional
        Advice to append to error messages.
    mode, buffering : str, int
        As for `open`, in binary mode.

    Raises
    ------
    FileAccessError
        When the file cannot be opened or is not a regular file; ``__cause__`` is the OSError, if any.
    """
    hint = f"; {remedy}" if remedy else ""
    no_link = 0
    if mode != "rb":  # whoever can place a link must not choose which file is changed
        no_link = getattr(os, "O_NOFOLLOW", 0)
        if os.path.islink(path):
            raise FileAccessError(f"{os.fspath(path)}: is not a file (got a link; delete it)")

    def opener(name: str, flags: int) -> int:
        # do not wait for the other end of a pipe; Windows has neither this flag nor such pipes
        descriptor = os.open(name, flags | getattr(os, "O_NONBLOCK", 0) | no_link, 0o666)
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
    """Remove any file of this name and open a new one: a link would lead elsewhere, a pipe would block.

    Raises
    ------
    OSError
        When the old file cannot be removed or the new one cannot be opened.
    """
    path.unlink(missing_ok=True)
    return path.open(mode, **text)


def read_bytes(path: str | os.PathLike[str], limit: int, remedy: str = "") -> bytes:
    """Content of a regular file of at most ``limit`` bytes.

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
    """UTF-8 text of a regular file of at most ``limit`` bytes, without a byte order mark.

    Raises
    ------
    FileAccessError
        As for `read_bytes`, and when the file is not UTF-8 text; ``__cause__`` is then the UnicodeDecodeError.
    """
    data = read_bytes(path, limit, remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        got = f"got the byte 0x{data[error.start]:02x} in line {line}"
        raise FileAccessError(f"{os.fspath(path)}: must be UTF-8 text ({got}; save it as UTF-8)") from error


def lines_of(file: BinaryIO, name: str | os.PathLike[str], longest: int) -> Iterator[bytes]:
    """Lines of ``file`` with their line ends, which the last may lack; ``name`` is for error messages.

    Raises
    ------
    FileAccessError
        When the file cannot be read, or has a line of ``longest`` bytes or more.
    """
    try:
        while line := file.readline(longest):
            if len(line) == longest:
                raise FileAccessError(f"{os.fspath(name)}: must have lines shorter than {_size(longest)} (got more)")
            yield line
    except OSError as error:
        raise _refused(name, error, "") from error


def parse_json(text: str | bytes, name: str, remedy: str = "") -> Any:
    """Value of a JSON text.

    Parameters
    ----------
    text : str or bytes
        Bytes are UTF-8.
    name : str
        Name of the text in error messages.
    remedy : str, optional
        Advice to append to the error message.

    Raises
    ------
    InvalidValueError
        When the text is not JSON, is nested too deeply, or contains NaN or an infinity, which JSON does not allow.
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
