"""Files that replace an old one only when they are whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from shockwave.errors import FileAccessError
from shockwave.files import open_new


@contextmanager
def replacing(file: Path) -> Iterator[IO[Any]]:
    """A new text file, which takes the place of ``file`` when it is whole, and is deleted when it is not.

    Raises
    ------
    FileAccessError
        When it cannot be written.
    """
    part = file.with_name(f"{file.name}.part")
    try:
        with open_new(part, "x", encoding="utf-8", errors="backslashreplace", newline="") as opened:
            yield opened
            opened.flush()
            os.fsync(opened.fileno())
        part.replace(file)
    except OSError as error:
        raise not_writable(file, error) from error
    finally:
        part.unlink(missing_ok=True)


def not_writable(file: Path, error: OSError) -> FileAccessError:
    """The error of a file that cannot be written, which names it."""
    return FileAccessError(f"{file}: cannot be written (got {error.strerror or error})")
