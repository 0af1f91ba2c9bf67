"""Memory: what was read of plugins is kept, until a file of theirs changes or anything is installed.

Without it every use of a plugin would begin with another process. Of faults only that a module does not end is kept,
for looking again takes long.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from shockwave import __version__
from shockwave.hooks import Entry
from shockwave.registration import stamp

__all__ = ["keep", "recall"]

_Task = tuple[str, ...]
# of an entry with its kind
_LENGTH = 1 + len(Entry._fields)


def recall(tasks: Sequence[_Task]) -> list[dict[str, Any] | None]:
    """The answer to each task that was kept and still holds, else None."""
    known = _read()
    return [_valid(known.get(_key(task))) for task in tasks]


def keep(tasks: Sequence[_Task], answers: Sequence[dict[str, Any]]) -> None:
    """Keep the answers that are no faults, as far as there is a place to write to."""
    good = {_key(task): answer for task, answer in zip(tasks, answers, strict=True) if answer.get("files")}
    if not good:
        return
    text = json.dumps({"place": _place(), "answers": _read() | good})
    # RuntimeError: there may be no home for anything to be kept in
    with contextlib.suppress(OSError, RuntimeError):
        file = _file()
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=file.parent, delete=False, encoding="ascii") as new:
            new.write(text)
        try:
            os.replace(new.name, file)
        except OSError:
            os.unlink(new.name)


def _valid(answer: object) -> dict[str, Any] | None:
    """``answer``, if the files that it was read from are what they were."""
    if not isinstance(answer, dict) or not (isinstance(answer.get("files"), dict) and answer["files"]):
        return None
    entries = answer.get("entries", [])
    if not isinstance(entries, list) or not all(isinstance(entry, list) and len(entry) == _LENGTH for entry in entries):
        return None
    try:
        same = all(stamp(file) == seen for file, seen in answer["files"].items())
    except OSError:
        return None
    return answer if same else None


def _read() -> dict[str, Any]:
    try:
        kept = json.loads(_file().read_text(encoding="ascii"))
    except (OSError, RuntimeError, ValueError):
        return {}
    sound = isinstance(kept, dict) and isinstance(kept.get("answers"), dict) and kept.get("place") == _place()
    return kept["answers"] if sound else {}


def _place() -> list[Any]:
    """Whatever is installed or removed changes one of these folders."""
    stamps = []
    for path in filter(lambda path: isinstance(path, str), sys.path):
        with contextlib.suppress(OSError):
            stamps.append([path, os.stat(path or os.curdir).st_mtime_ns])
    return [__version__, sys.version, stamps]


def _file() -> Path:
    from platformdirs import user_cache_path

    environment = hashlib.sha256(os.fsencode(sys.prefix)).hexdigest()[:16]
    return user_cache_path("shockwave", appauthor=False) / f"plugins-{environment}.json"


def _key(task: _Task) -> str:
    return "|".join(task)
