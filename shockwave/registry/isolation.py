"""Isolation: a plugin's code is first run in a process of its own, where it may raise, hang or crash.

The parent sends tasks, ``("read", module)`` or ``("load", kind, address)``, and gets an answer to each, in order. A
process that dies or stays silent costs the task that it was at; the rest goes to another.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from typing import Any

from attrs import define, field

from shockwave.errors import PluginError, UsageError
from shockwave.registration import READY, stamp
from shockwave.registry.memory import keep, recall

__all__ = ["Isolated", "time_limit"]

_LIMIT = "SHOCKWAVE_PLUGIN_TIMEOUT"
_USUAL_LIMIT, _LONGEST = 10.0, 3600
_PROGRAM = "import sys; sys.path[:] = {path!r}; from shockwave.registration import answer_all; answer_all()"


def time_limit() -> float:
    """Seconds that a plugin may take: SHOCKWAVE_PLUGIN_TIMEOUT, or 10.

    Raises
    ------
    UsageError
        When the variable is no number above 0.
    """
    text = os.environ.get(_LIMIT) or str(_USUAL_LIMIT)
    try:
        limit = float(text)
    except ValueError:
        limit = 0.0
    if not 0 < limit <= _LONGEST:
        raise UsageError(f"{_LIMIT} must be a number of seconds > 0 and <= {_LONGEST} (got {text!r})")
    return limit


@define(eq=False)
class Isolated:
    """Tasks under way in a process of their own, which begins at once; `answers` waits for it.

    What was answered before and still holds is not asked again, unless ``anew``.
    """

    tasks: Sequence[tuple[str, ...]]
    anew: bool = False
    limit: float = field(factory=time_limit)
    _known: list[dict[str, Any] | None] = field(init=False)
    _process: subprocess.Popen[bytes] | None = field(init=False, default=None)

    def __attrs_post_init__(self) -> None:
        self._known = [None] * len(self.tasks) if self.anew else recall(self.tasks)
        open_tasks = self._open()
        if open_tasks:
            self._process = _begun(open_tasks)

    def _open(self) -> list[tuple[str, ...]]:
        return [task for task, known in zip(self.tasks, self._known, strict=True) if known is None]

    def answers(self) -> list[dict[str, Any]]:
        """The answer to each task: what was asked for, or its ``problem``."""
        asked = self._open()
        found = self._found(asked)
        # What one plugin has done to its process must not be told of another.
        if len(asked) > 1:
            for index, task in enumerate(asked):
                if found[index].get("again"):
                    self._process = _begun([task])
                    found[index] = self._found([task])[0]
        if asked:
            keep(asked, found)
        more = iter(found)
        return [next(more) if known is None else known for known in self._known]

    def stop(self) -> None:
        """End the process, of which nothing more is wanted."""
        if self._process is not None:
            _ended(self._process)

    def _found(self, asked: Sequence[tuple[str, ...]]) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        while self._process is not None:
            problem: dict[str, Any] = {}
            try:
                for answer in _answers(self._process, self.limit, len(asked) - len(found)):
                    found.append(answer | {"again": True} if "problem" in answer else answer)
            except TimeoutError:
                told = f"does not end (stopped after {self.limit:g} s; `shockwave list plugins --check` asks again)"
                problem = {"problem": told, "files": _sources(asked[len(found)])}
            finally:
                status = _ended(self._process)
            if len(found) < len(asked):
                found.append(problem or {"problem": _ending(status), "again": True})
            left = asked[len(found) :]
            self._process = _begun(left) if left else None
        return found


def _sources(task: tuple[str, ...]) -> dict[str, list[int]]:
    """Files in which a module that was never imported seems to stand."""
    parts = (task[1] if task[0] == "read" else task[2].partition(":")[0]).split(".")
    found = {}
    for end in range(1, len(parts) + 1):
        for folder in filter(lambda path: isinstance(path, str), sys.path):
            place = os.path.join(folder, *parts[:end])
            for file in (f"{place}.py", os.path.join(place, "__init__.py")):
                if os.path.isfile(file):
                    found[file] = stamp(file)
    return found


def _begun(tasks: Sequence[tuple[str, ...]]) -> subprocess.Popen[bytes]:
    path = [folder for folder in sys.path if isinstance(folder, str)]
    try:
        process = subprocess.Popen(
            [sys.executable or "python", "-c", _PROGRAM.format(path=path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
    except OSError as error:
        raise PluginError(f"plugins cannot be read, as no process can be started ({error})") from error
    assert process.stdin is not None
    try:
        with process.stdin as stdin:
            stdin.write(json.dumps(tasks).encode())
    except BrokenPipeError:
        pass  # it has ended; its status tells
    return process


def _answers(process: subprocess.Popen[bytes], limit: float, count: int) -> Iterator[dict[str, Any]]:
    """``count`` answers as they come, or fewer; TimeoutError when one takes longer than ``limit``."""
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    assert process.stdout is not None
    stdout = process.stdout

    def read() -> None:
        with stdout:
            for line in stdout:
                lines.put(line)
        lines.put(b"")

    threading.Thread(target=read, daemon=True).start()
    for number in range(count + 1):
        try:
            line = lines.get(timeout=limit)
        except queue.Empty:
            raise TimeoutError from None
        try:
            answer = json.loads(line) if line else None
        except ValueError:
            answer = None
        if number == 0:
            if answer != READY:
                raise PluginError(f"plugins cannot be read, as {sys.executable or 'python'!r} does not run shockwave")
        elif isinstance(answer, dict):
            yield answer
        else:
            return


def _ended(process: subprocess.Popen[bytes]) -> int:
    """The status of a process that has ended, or is ended now."""
    try:
        return process.wait(timeout=0.2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return 0


def _ending(status: int) -> str:
    if status >= 0:
        return f"ends, or closes, the process that imports it (status {status})"
    try:
        return f"crashes the process that imports it ({signal.Signals(-status).name})"
    except ValueError:
        return f"crashes the process that imports it (signal {-status})"
