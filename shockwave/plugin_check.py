"""Check of plugins: each plugin is imported in a separate process, where it may raise, hang or crash.

Run as a program, this module is that process: it imports a module of hooks and everything that the hooks register.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from attrs import evolve

from shockwave.hooks import Entry
from shockwave.registry import PLUGIN_FAULTS, Plugin, described, installed, loaded_entry, read

#: Longest time of one plugin [s]: far more than any import takes.
TIME_LIMIT = 60.0


def checked_plugins() -> list[Plugin]:
    """Every installed plugin, with the problems of importing it and everything that it registers."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(_checked, installed()))


def _checked(plugin: Plugin) -> Plugin:
    if plugin.disabled:
        return plugin
    # -P: a module in the current folder must not replace an installed one
    command = [sys.executable, "-P", "-m", "shockwave.plugin_check", plugin.module]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        return evolve(plugin, problem=f"does not end (stopped after {TIME_LIMIT:g} s)")
    if done.returncode or not done.stdout:
        return evolve(plugin, problem=f"ends or crashes the process that imports it (status {done.returncode})")
    answer = json.loads(done.stdout)
    entries = tuple((kind, Entry(*entry)) for kind, entry in answer["entries"])
    return evolve(plugin, entries=entries, problem=answer["problem"])


def _answer(module: str) -> dict[str, Any]:
    """Entries that a module of hooks registers, and all problems."""
    plugin = read(Plugin("", "", module))
    problems = [plugin.problem] if plugin.problem else []
    for kind, entry in plugin.entries:
        try:
            loaded_entry(kind, entry)
        except PLUGIN_FAULTS as error:
            problems.append(described(error, kind, entry))
    return {"entries": plugin.entries, "problem": "; ".join(problems)}


if __name__ == "__main__":
    stdout = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # printed output of a plugin must not mix with the answer
    print(json.dumps(_answer(sys.argv[1])), file=stdout, flush=True)
    os._exit(0)  # threads that a plugin has begun must not keep this process
