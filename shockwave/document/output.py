"""Writing files: a file is there whole, or stays as it was; what is read is never written over."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from collections.abc import Iterable

from shockwave.errors import FileAccessError, UsageError

__all__ = ["refuse_inputs", "write_file"]

_Path = str | os.PathLike[str]
# Names of files that are open already: another file in their place would not be what is open.
_STREAMS = ("/dev/std", "/dev/fd/", "/proc/")


def write_file(path: _Path, content: str | bytes, anew: bool = False) -> None:
    """Write ``content`` beside ``path``, then put it in its place: on a full disk the old file stays.

    Parameters
    ----------
    path : path-like
        A link stays, and what it points to is replaced. A device or a pipe is written to directly. The permissions
        of a file that is replaced are kept.
    content : str or bytes
        Text is encoded as UTF-8.
    anew : bool
        The file must not exist.

    Raises
    ------
    FileAccessError
        When the file cannot be written.
    """
    # the name of a file need not be text
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    try:
        if anew and os.path.lexists(path):
            raise FileAccessError(f"{os.fspath(path)}: cannot be written (it exists already; choose another name)")
        _write(os.fspath(path), data)
    except OSError as error:
        raise FileAccessError(f"{os.fspath(path)}: cannot be written ({error.strerror or error})") from error
    except ValueError as error:  # a NUL character in the path
        raise FileAccessError(f"{os.fspath(path)!r}: is no path (got {error})") from None


def _write(path: str, data: bytes) -> None:
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        mode = None
    direct = mode is not None and (not stat.S_ISREG(mode) or not os.access(path, os.W_OK))
    if direct or path.startswith(_STREAMS):
        with open(path, "wb") as file:  # or the error that says why it cannot be
            file.write(data)
        return
    target = os.path.realpath(path)
    part = os.path.join(os.path.dirname(target), f".shockwave-{secrets.token_hex(8)}.part")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())  # some file systems find out only then that they are full
        if mode is not None:
            os.chmod(part, stat.S_IMODE(mode))
        os.replace(part, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(part)
        raise


def refuse_inputs(output: _Path, inputs: Iterable[_Path]) -> None:
    """Raise `UsageError` if ``output`` is one of the files that are read, under whatever name."""
    for path in inputs:
        try:
            same = os.path.samefile(output, path)
        except (OSError, ValueError):  # one of them does not exist
            continue
        if same:
            got = f"got {os.fspath(output)}, which is {os.fspath(path)}; choose another name"
            raise UsageError(f"--output: must be another file than those that are read ({got})")
