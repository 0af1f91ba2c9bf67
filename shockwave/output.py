"""Writing of files: only a complete file replaces an old one, and input files are never overwritten."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from collections.abc import Iterable

from shockwave.errors import FileAccessError, UsageError

__all__ = ["refuse_inputs", "write_file"]

_Path = str | os.PathLike[str]
# Prefixes of names of open files: a new file of the same name would not replace the open one.
_STREAMS = ("/dev/std", "/dev/fd/", "/proc/")


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
    try:
        (_write_new if anew else _write)(os.fspath(path), data)
    except OSError as error:
        exists = isinstance(error, FileExistsError)
        reason = "it exists already; choose another name" if exists else error.strerror or error
        raise FileAccessError(f"{os.fspath(path)}: cannot be written ({reason})") from error
    except ValueError as error:  # a NUL character in the path
        raise FileAccessError(f"{os.fspath(path)!r}: is no path (got {error})") from None


def _write_new(path: str, data: bytes) -> None:
    with open(path, "xb") as file:
        try:
            file.write(data)
            file.flush()
        except BaseException:
            os.remove(path)
            raise


def _write(path: str, data: bytes) -> None:
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        mode = None
    target = os.path.realpath(path)
    folder = os.path.dirname(target)
    direct = mode is not None and not (stat.S_ISREG(mode) and os.access(path, os.W_OK) and os.access(folder, os.W_OK))
    if direct or path.startswith(_STREAMS):
        with open(path, "wb") as file:  # raises an error if the file is not writable
            file.write(data)
        return
    part = os.path.join(folder, f".shockwave-{secrets.token_hex(8)}.part")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())  # some file systems report a full disk only here
        if mode is not None:
            os.chmod(part, stat.S_IMODE(mode))
        os.replace(part, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(part)
        raise


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
