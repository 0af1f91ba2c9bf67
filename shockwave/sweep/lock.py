"""A lock on a folder, held by a process as long as it lives: the system lets go of it when the process ends."""

from __future__ import annotations

import errno
import json
import os
import platform
import sys
import weakref
from pathlib import Path
from typing import BinaryIO

from shockwave.errors import FileAccessError
from shockwave.files import open_regular

__all__ = ["locked"]

# Where on Windows the lock lies: beyond the text, which others may then still read.
_FAR = 1 << 20
# Most bytes that are read to identify the holder.
_MOST = 1000
_HELD = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
_files = weakref.WeakSet[BinaryIO]()


def _leave() -> None:
    for opened in list(_files):
        opened.close()


if hasattr(os, "register_at_fork"):
    # a copy of this process that outlives it would keep the folder locked
    os.register_at_fork(after_in_child=_leave)


def locked(file: Path) -> BinaryIO:
    """The file, opened and locked until it is closed or the process ends, however it ends.

    Raises
    ------
    FileAccessError
        When another process holds it; the message tells which. When it cannot be written.
    """
    opened = open_regular(file, mode="a+b", buffering=0)
    try:
        _lock(opened)
    except OSError as error:
        holder = _holder(opened)
        opened.close()
        if error.errno not in _HELD:
            got = f"got {error.strerror}: this file system has no locks; choose a folder on another"
            raise FileAccessError(f"{file}: must be locked ({got})") from error
        problem = f"must be used by one client at a time (got {holder}; wait for it, or end it)"
        raise FileAccessError(f"{file.parent}: {problem}") from None
    _files.add(opened)
    opened.truncate(0)
    opened.write(json.dumps({"pid": os.getpid(), "host": platform.node()}).encode())
    return opened


def _holder(opened: BinaryIO) -> str:
    try:
        opened.seek(0)
        holder = json.loads(opened.read(_MOST))
        return f"process {holder['pid']} on {holder['host']}"
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return "another process"


if sys.platform == "win32":
    import msvcrt

    def _lock(opened: BinaryIO) -> None:
        opened.seek(_FAR)
        msvcrt.locking(opened.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(opened: BinaryIO) -> None:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
