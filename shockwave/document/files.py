"""Reading files that anybody may have written: regular files only, up to a limit, with errors in plain words."""

from __future__ import annotations

import json
import os
import stat
from typing import Any, BinaryIO

from shockwave.errors import FileAccessError, InvalidValueError

__all__ = ["open_regular", "parse_json", "read_bytes", "read_text"]


def open_regular(path: str | os.PathLike[str], remedy: str = "") -> BinaryIO:
    """Open a regular file for reading; a pipe or a device, which may never end, is refused without waiting for it.

    Parameters
    ----------
    path : path-like
        Links are followed.
    remedy : str, optional
        What to do about a file that cannot be read, for the message.

    Raises
    ------
    FileAccessError
        When it cannot be opened, or is no regular file; its ``__cause__`` is the OSError, if there was one.
    """
    hint = f"; {remedy}" if remedy else ""
    try:
        file: BinaryIO = open(path, "rb", opener=_open_at_once)  # noqa: SIM115
    except IsADirectoryError as error:
        raise FileAccessError(f"{os.fspath(path)}: is not a file (got a folder{hint})") from error
    except OSError as error:
        raise _unreadable(path, error, hint) from error
    except ValueError as error:  # a NUL character in the path
        raise FileAccessError(f"{os.fspath(path)!r}: is no path (got {error}{hint})") from None
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise FileAccessError(f"{os.fspath(path)}: is not a file (got a pipe or a device{hint})")
    return file


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
            raise _unreadable(path, error, hint) from error
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
        return json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:  # a UnicodeDecodeError is a ValueError
        got = "lists or mappings nested too deeply" if isinstance(error, RecursionError) else error
        hint = f"; {remedy}" if remedy else ""
        raise InvalidValueError.of(name, f"must be JSON (got {got}{hint})") from None


def _no_constant(constant: str) -> None:
    raise ValueError(f"the number {constant}")


def _open_at_once(path: str, flags: int) -> int:
    """Open a file; the other end of a pipe is not waited for (Windows has no such flag, and no such pipes)."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _unreadable(path: str | os.PathLike[str], error: OSError, hint: str) -> FileAccessError:
    return FileAccessError(f"{os.fspath(path)}: cannot be read (got {error.strerror or error}{hint})")


def _size(limit: int) -> str:
    return f"{limit >> 20} MiB" if limit >= 2**20 else f"{limit} bytes"
