"""Reading and writing of files: regular files of limited size are read, only complete files replace old ones."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO

from shockwave.errors import FileAccessError, InvalidValueError, UsageError

_Path = str | os.PathLike[str]
# A new file in place of an open stream would not reach whoever reads the stream.
_STREAMS = ("/dev/", "/proc/")


# ---------------------------------------------------------------- reading


def open_regular(path: _Path, remedy: str = "", mode: str = "rb", buffering: int = -1) -> BinaryIO:
    """Open a regular file; refuse a pipe or a device, which may never end, without waiting for it.

    Parameters
    ----------
    path : path-like
        Links are followed for reading, and refused for writing: they could point to any file.
    remedy : str, optional
        Advice to append to error messages.
    mode, buffering : str, int
        As for `open`, in binary mode.

    Raises
    ------
    FileAccessError
        When the file cannot be opened or is not a regular file; ``__cause__`` is the OSError, if any.
    """
    if mode != "rb" and os.path.islink(path):
        raise _not_a_file(path, "a link; delete it")
    if os.path.isdir(path):
        raise _not_a_file(path, f"a folder{_hint(remedy)}")
    if os.path.exists(path) and not os.path.isfile(path):
        raise _not_a_file(path, f"a pipe or a device{_hint(remedy)}")
    try:
        file: Any = open(path, mode, buffering)  # noqa: SIM115
    except (OSError, ValueError) as error:  # a ValueError for a NUL character in the path
        raise _refused(path, error, "read" if mode == "rb" else "written", remedy) from error
    opened: BinaryIO = file
    return opened


def read_bytes(path: _Path, limit: int, remedy: str = "") -> bytes:
    """Content of a regular file of at most ``limit`` bytes.

    Raises
    ------
    FileAccessError
        As for `open_regular`, and when the file is larger.
    """
    with open_regular(path, remedy) as file:
        try:
            data = file.read(limit + 1)
        except OSError as error:
            raise _refused(path, error, "read", remedy) from error
    if len(data) > limit:
        raise FileAccessError(f"{os.fspath(path)}: must be at most {_size(limit)} (got more{_hint(remedy)})")
    return data


def read_text(path: _Path, limit: int, remedy: str = "") -> str:
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


def lines_of(file: BinaryIO, name: _Path, longest: int) -> Iterator[bytes]:
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
        raise _refused(name, error, "read") from error


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
        raise InvalidValueError.of(name, f"must be JSON (got {error}{_hint(remedy)})") from None


def _no_constant(constant: str) -> None:
    raise ValueError(f"the number {constant}")


# ---------------------------------------------------------------- writing


def write_file(path: _Path, content: str | bytes, anew: bool = False) -> None:
    """Write ``content`` to a temporary file that then replaces ``path``: if the disk is full, the old file remains.

    Parameters
    ----------
    path : path-like
        The target of a link is replaced, not the link. A device or a pipe is written to directly. The new file keeps
        the permissions of the old one.
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
    try:
        target = os.path.realpath(path)
        if _replaceable(target) and not os.fspath(path).startswith(_STREAMS):
            _replace(target, data)
        else:
            with open(path, "wb") as file:  # raises an error if the file is not writable
                file.write(data)
    except (OSError, ValueError) as error:
        raise FileAccessError(f"{os.fspath(path)}: cannot be written ({_reason(error)})") from error


def _replaceable(target: str) -> bool:
    """Whether ``target`` is missing or a regular file, and both it and its folder can be written."""
    regular = os.path.isfile(target) and os.access(target, os.W_OK)
    return os.access(os.path.dirname(target), os.W_OK) and (regular or not os.path.exists(target))


def _replace(target: str, data: bytes) -> None:
    part = os.path.join(os.path.dirname(target), f".shockwave-{secrets.token_hex(8)}.part")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())  # some file systems report a full disk only here
        if os.path.exists(target):
            os.chmod(part, stat.S_IMODE(os.stat(target).st_mode))
        os.replace(part, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(part)
        raise


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[IO[str]]:
    """A new text file, which takes the place of ``path`` when it is complete, and is deleted when it is not.

    A link of this name, or of the temporary file, is replaced, not followed.

    Raises
    ------
    FileAccessError
        When it cannot be written.
    """
    part = path.with_name(f"{path.name}.part")
    try:
        part.unlink(missing_ok=True)
        with part.open("x", encoding="utf-8", errors="backslashreplace", newline="") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        raise not_writable(path, error) from error
    finally:
        part.unlink(missing_ok=True)


def not_writable(path: _Path, error: OSError) -> FileAccessError:
    """The error of a file that cannot be written, which names it."""
    return _refused(path, error, "written")


def refuse_inputs(output: _Path, inputs: Iterable[_Path]) -> None:
    """Raise `UsageError` if ``output`` is one of the input files, even under another name."""
    for path in inputs:
        try:
            same = os.path.samefile(output, path)
        except (OSError, ValueError):  # one of them does not exist
            continue
        if same:
            got = f"got {os.fspath(output)}, which is {os.fspath(path)}; choose another name"
            raise UsageError(f"--output: must not be an input file ({got})")


# ---------------------------------------------------------------- messages


def _refused(path: _Path, error: OSError | ValueError, what: str, remedy: str = "") -> FileAccessError:
    return FileAccessError(f"{os.fspath(path)}: cannot be {what} (got {_reason(error)}{_hint(remedy)})")


def _not_a_file(path: _Path, got: str) -> FileAccessError:
    return FileAccessError(f"{os.fspath(path)}: is not a file (got {got})")


def _reason(error: OSError | ValueError) -> str:
    return str(getattr(error, "strerror", None) or error)


def _hint(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""


def _size(limit: int) -> str:
    return f"{limit >> 20} MiB" if limit >= 2**20 else f"{limit} bytes"
