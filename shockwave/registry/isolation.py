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
from shockwave.registry.memory import keep, recall

__all__ = ["Isolated", "time_limit"]

_LIMIT = "SHOCKWAVE_PLUGIN_TIMEOUT"
_USUAL_LIMIT = 10.0
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
    if not 0 < limit < float("inf"):
        raise UsageError(f"{_LIMIT} must be a number of seconds > 0 (got {text!r})")
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
        if asked:
            keep(asked, found)
        more = iter(found)
        return [next(more) if known is None else known for known in self._known]

    def _found(self, asked: Sequence[tuple[str, ...]]) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        while self._process is not None:
            end = ""
            try:
                for answer in _answers(self._process, self.limit):
                    found.append(answer)
            except TimeoutError:
                end = f"does not end (stopped after {self.limit:g} s)"
            finally:
                self._process.kill()
                status = self._process.wait()
            if len(found) < len(asked):
                found.append({"problem": end or _ending(status)})
            left = asked[len(found) :]
            self._process = _begun(left) if left else None
        return found


def _begun(tasks: Sequence[tuple[str, ...]]) -> subprocess.Popen[bytes]:
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM.format(path=sys.path)],
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


def _answers(process: subprocess.Popen[bytes], limit: float) -> Iterator[dict[str, Any]]:
    """Answers as they come; TimeoutError when one takes longer than ``limit``."""
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    assert process.stdout is not None
    stdout = process.stdout

    def read() -> None:
        with stdout:
            for line in stdout:
                lines.put(line)
        lines.put(b"")

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            line = lines.get(timeout=limit)
        except queue.Empty:
            raise TimeoutError from None
        if not line.endswith(b"\n"):
            return
        yield json.loads(line)


def _ending(status: int) -> str:
    if status >= 0:
        return f"ends the process that imports it (status {status})"
    try:
        return f"crashes the process that imports it ({signal.Signals(-status).name})"
    except ValueError:
        return f"crashes the process that imports it (signal {-status})"
