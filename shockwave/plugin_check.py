"""Check of plugins: each plugin is imported in a separate process, because it may raise, hang or crash.

As a script, this module is that process: it imports a module of hooks and everything that the hooks register.
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

#: Time limit of one plugin [s], much longer than any import.
TIME_LIMIT = 60.0


def checked_plugins() -> list[Plugin]:
    """All installed plugins, with the errors of their imports and of everything that they register."""
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
    """Entries that a module of hooks registers, and all errors."""
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
    os.dup2(2, 1)  # keeps printed output of plugins apart from the answer
    print(json.dumps(_answer(sys.argv[1])), file=stdout, flush=True)
    os._exit(0)  # does not wait for threads of plugins
