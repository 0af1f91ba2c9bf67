"""Check of plugins: each plugin is imported in a separate process, where it may raise, hang or crash.

Run as a program, this module is that process: it imports a module of hooks and everything that the hooks register, and
writes one line of JSON after each step. The number of lines shows which step ended the process.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from attrs import evolve

from shockwave.errors import UsageError
from shockwave.hooks import Entry
from shockwave.registry import KINDS, Plugin, described, installed, loaded_entry, registered, without_clashes

_LIMIT = "SHOCKWAVE_PLUGIN_TIMEOUT"
_USUAL_LIMIT = "10"  # s
_LONGEST = 3600  # s


def time_limit() -> float:
    """Seconds that a plugin may take: SHOCKWAVE_PLUGIN_TIMEOUT, or 10.

    Raises
    ------
    UsageError
        When the variable is no number above 0.
    """
    text = os.environ.get(_LIMIT) or _USUAL_LIMIT
    try:
        limit = float(text)
    except ValueError:
        limit = 0.0
    if not 0 < limit <= _LONGEST:
        raise UsageError(f"{_LIMIT} must be a number of seconds > 0 and <= {_LONGEST} (got {text!r})")
    return limit


def checked_plugins() -> tuple[Plugin, ...]:
    """Every installed plugin, with the problems of importing it and everything that it registers."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return without_clashes(pool.map(partial(_checked, limit=time_limit()), installed()))


def _checked(plugin: Plugin, limit: float) -> Plugin:
    if not plugin.module:
        return plugin
    # -P: a module in the current folder must not replace an installed one
    command = [sys.executable, "-P", "-m", "shockwave.plugin_check", plugin.module]
    with tempfile.TemporaryFile() as answers:  # not a pipe: a process that the plugin leaves behind would keep it open
        try:
            status = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=answers, timeout=limit).returncode
            ending = _ending(status)
        except subprocess.TimeoutExpired:
            ending = f"does not end (stopped after {limit:g} s)"
        answers.seek(0)
        steps: list[dict[str, Any]] = [json.loads(line) for line in answers if line.endswith(b"\n")]
    if not steps:
        return evolve(plugin, problem=ending)
    entries = tuple((kind, Entry(*entry)) for kind, *entry in steps[0].get("entries", ()))
    problems = [step["problem"] for step in steps if "problem" in step]
    if len(steps) <= len(entries):
        problems.append(f"{_subject(*entries[len(steps) - 1])}: {ending}")
    return evolve(plugin, entries=entries, problem="; ".join(problems))


def _subject(kind: str, entry: Entry) -> str:
    return f"{KINDS[kind]} {entry.name!r}: {entry.address}"


def _ending(status: int) -> str:
    if status >= 0:
        return f"ends, or closes, the process that imports it (status {status})"
    return f"crashes the process that imports it ({signal.Signals(-status).name})"


def _steps(module: str) -> Iterator[dict[str, Any]]:
    """Entries that a module of hooks registers, then the problem of each entry, if any."""
    try:
        entries = registered(module)
    except BaseException as error:
        yield {"problem": described(error)}
        return
    yield {"entries": [(kind, *entry) for kind, entry in entries]}
    for kind, entry in entries:
        try:
            loaded_entry(kind, entry)
            yield {}
        except BaseException as error:
            yield {"problem": f"{_subject(kind, entry)}: {described(error)}"}


if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)  # printed output of a plugin must not mix with the answers
    for step in _steps(sys.argv[1]):
        print(json.dumps(step), file=answers, flush=True)
    os._exit(0)  # threads that a plugin has begun must not keep this process
