"""Reading and writing of files: only regular files of limited size are read, only complete files replace old ones."""

from __future__ import annotations

import codecs
import json
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any, TypeVar

from shockwave.base.errors import FileAccessError, InvalidValueError, UsageError, text_of

_Path = str | os.PathLike[str]
_Type = TypeVar("_Type")

# A stream must be written to directly: its reader would not see a new file of the same name.
_STREAMS = ("/dev/", "/proc/")


# ---------------------------------------------------------------- reading


def open_regular(path: _Path, remedy: str = "", mode: str = "rb") -> IO[bytes]:
    """Open a regular file; refuse a pipe or a device, which may be endless, without waiting for it.

    Parameters
    ----------
    path : path-like
        Links are followed for reading, but refused for writing, because they could point to any file.
    remedy : str, optional
        Advice to append to error messages.
    mode : str
        As for `open`, in binary mode.

    Raises
    ------
    FileAccessError
        When the file cannot be opened or is not a regular file; ``__cause__`` is the OSError, if any.
    InvalidValueError
        When ``path`` is not one.
    """
    if not isinstance(path, str | bytes | os.PathLike):  # an integer would be an open file of this process
        raise InvalidValueError.of("path", f"must be the path of a file (got {text_of(path)})")
    if mode != "rb":
        refuse_link(path)
    if os.path.exists(path) and not os.path.isfile(path):
        raise _error(path, "is not a file", "a folder" if os.path.isdir(path) else "a pipe or a device", remedy)
    try:
        return open(path, mode)
    except (OSError, ValueError) as error:  # a ValueError for a NUL character in the path
        raise _error(path, "cannot be read" if mode == "rb" else "cannot be written", error, remedy) from error


def read_bytes(path: _Path, limit: int, remedy: str = "") -> bytes:
    """Content of a regular file of at most ``limit`` bytes.

    Raises
    ------
    FileAccessError
        As for `open_regular`, and when the file is larger.
    """
    with open_regular(path, remedy) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise _error(path, f"must be at most {limit} bytes", "more", remedy)
    return data


def read_text(path: _Path, limit: int, encoding: str | None = None) -> str:
    """Text of a regular file of at most ``limit`` bytes, without a byte order mark.

    By default it is UTF-16 if it begins with the byte order mark of UTF-16, otherwise UTF-8.

    Raises
    ------
    FileAccessError
        As for `read_bytes`, and when the file is not text in the encoding.
    """
    data = read_bytes(path, limit)
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    name = encoding or ("utf-16" if marked else "utf-8")
    try:
        text = data.decode("utf-8-sig" if name == "utf-8" else name)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        got = f"the byte 0x{data[error.start]:02x} in line {line}"
        raise _error(path, f"must be text in {name}", got, "many instruments need encoding: cp1252") from error
    if "\0" in text:
        raise _error(path, f"must be text in {name}", "a zero byte", "encoding: utf-16 has them")
    return text


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
        When the text is not JSON, or contains NaN or an infinity, which JSON does not allow.
    """
    try:
        return json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:  # a UnicodeDecodeError is a ValueError
        raise InvalidValueError.of((), f"must be JSON (got {error}{_hint(remedy)})", name) from None


def structure_document(document: Any, cls: type[_Type], name: str, rule: str, remedy: str = "") -> _Type:
    """Instance of an attrs class from plain data.

    Parameters
    ----------
    document : object
        Plain data, such as those of `parse_json`.
    cls : type
        The class.
    name, rule, remedy : str
        Name of the data, what they must be, and advice, for the error message.

    Raises
    ------
    InvalidValueError
        When the data do not fit the class.
    """
    from cattrs import structure, transform_error

    try:
        return structure(document, cls)
    except Exception as error:  # cattrs passes on the errors of the values
        reasons = "; ".join(transform_error(error, "document", _reason))
        problem = f"must be {rule} (got {reasons[:200]}{_hint(remedy)})"
        raise InvalidValueError.of((), problem, name) from None


def _reason(error: BaseException, kind: Any) -> str:
    """The message of an error of shockwave itself, or that of cattrs for others."""
    from cattrs.v import format_exception

    return str(error) if isinstance(error, InvalidValueError) else format_exception(error, kind)


def _no_constant(constant: str) -> None:
    raise ValueError(f"the number {constant}")


# ---------------------------------------------------------------- writing


def write_file(path: _Path, content: str | bytes, anew: bool = False) -> None:
    """Write ``content`` to a temporary file that then replaces ``path``: if the disk is full, the old file remains.

    Parameters
    ----------
    path : path-like
        The target of a link is replaced, not the link. A device or a pipe is written to directly.
    content : str or bytes
        Text is encoded as UTF-8.
    anew : bool
        Whether the file must not exist yet.

    Raises
    ------
    FileAccessError
        When the file cannot be written.
    """
    # the content may include file names that are not valid text
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    if anew and os.path.lexists(path):
        raise FileAccessError(f"{os.fspath(path)}: cannot be written (it exists already; choose another name)")
    target = Path(path)
    try:
        if os.fspath(path).startswith(_STREAMS) or (target.exists() and not target.is_file()):
            with target.open("ab") as file:  # a stream may be a file that others append to
                file.write(data)
            return
        if target.exists() and not os.access(target, os.W_OK):
            raise ValueError("it is read-only")
        if target.is_symlink():
            target = target.resolve()
        with replace_file(target) as new:
            new.buffer.write(data)
    except (OSError, ValueError) as error:
        raise not_writable(path, error) from error


@contextmanager
def replace_file(path: Path) -> Iterator[TextIOWrapper]:
    """A new text file that replaces ``path`` when it is complete, and is deleted otherwise.

    A link of this name is replaced, not followed. The new file gets the permissions of the old one.

    Raises
    ------
    FileAccessError
        When it cannot be written.
    """
    part = path.with_name(f".shockwave-{os.urandom(8).hex()}.part")
    try:
        with part.open("x", encoding="utf-8", errors="backslashreplace", newline="") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())  # some file systems report a full disk only here
        if path.is_file() and not path.is_symlink():
            part.chmod(stat.S_IMODE(path.stat().st_mode))
        part.replace(path)
    except OSError as error:
        raise not_writable(path, error) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def refuse_link(path: _Path) -> None:
    """Raise `FileAccessError` if ``path`` is a link, which could make a file anywhere be written."""
    if os.path.islink(path):
        raise _error(path, "is not a file", "a link", "delete it")


def refuse_inputs(output: _Path, inputs: Iterable[_Path]) -> None:
    """Raise `UsageError` if ``output`` is one of the input files, even under another name."""
    for path in inputs:
        if os.path.exists(output) and os.path.exists(path) and os.path.samefile(output, path):
            got = f"got {os.fspath(output)}, which is {os.fspath(path)}; choose another name"
            raise UsageError(f"--output: must not be an input file ({got})")


# ---------------------------------------------------------------- messages


def not_writable(path: _Path, error: Exception) -> FileAccessError:
    """Error of a file that cannot be written."""
    return _error(path, "cannot be written", error)


def _error(path: _Path, problem: str, got: object, remedy: str = "") -> FileAccessError:
    found = getattr(got, "strerror", None) or (got if isinstance(got, Exception) else f"got {got}")
    return FileAccessError(f"{os.fspath(path)}: {problem} ({found}{_hint(remedy)})")


def _hint(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""
