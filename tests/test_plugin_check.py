"""`list plugins --check`: each plugin is imported in a process of its own, which may exit, crash or hang."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from conftest import HOOKS, PULSE, Install
from distributions import describe
from shockwave.errors import UsageError
from shockwave.plugin_check import checked_plugins, time_limit

#: Time that no sound plugin takes, however busy the machine is [s].
GENEROUS = "600"

#: Code that fails on import, and what is reported of it.
FAULTS = {
    "raises": ("raise RuntimeError('out of order')", "RuntimeError: out of order"),
    "exits": ("import sys; sys.exit(3)", "SystemExit: 3"),
    "interrupts": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    "leaves": ("import os; os._exit(7)", "ends, or closes, the process that imports it (status 7)"),
    "segfaults": (
        "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
        "crashes the process that imports it (SIGSEGV)",
    ),
}
#: What a module may do and still be sound: nothing of it reaches the answers.
SOUND = {
    "plain": "",
    "prints": "import os; print('noise'); os.write(1, b'noise')",
    "runs-on": "import threading; threading.Thread(target=threading.Event().wait).start()",
}
HANG = "import time; time.sleep(3600)"


def put(site: Path, name: str, hooks: str = "", pulse: str = "") -> None:
    """Put a distribution into a folder; ``hooks`` and ``pulse`` stand at the head of its modules."""
    module = name.replace("-", "_")
    (site / f"{module}.py").write_text(f"{hooks}\n{HOOKS.format(name=name, module=module)}")
    (site / f"{module}_pulse.py").write_text(f"{pulse}\n{PULSE}")
    describe(site, name, "1.2", {name: module})


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], int]:
    """A row for each plugin, of all of them side by side, and the exit status; by the command in a process."""
    site = tmp_path_factory.mktemp("site")
    for name, (code, _) in FAULTS.items():
        put(site, f"hooks-{name}", hooks=code)
        put(site, f"pulse-{name}", pulse=code)
    for name, code in SOUND.items():
        put(site, f"sound-{name}", hooks=code)
    done = subprocess.run(
        [sys.executable, "-m", "shockwave", "list", "plugins", "--check", "--json"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(site), "SHOCKWAVE_PLUGIN_TIMEOUT": GENEROUS},
    )
    return {row["name"]: row for row in json.loads(done.stdout)}, done.returncode


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_the_hooks_is_reported(checked: tuple[dict[str, Any], int], name: str) -> None:
    row = checked[0][f"hooks-{name}"]
    assert (row["version"], row["entries"], row["checked"]) == ("1.2", [], True)
    assert row["problem"].startswith(FAULTS[name][1])


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_what_is_registered_is_reported(checked: tuple[dict[str, Any], int], name: str) -> None:
    row = checked[0][f"pulse-{name}"]
    assert row["entries"] == [{"kind": "profiles", "name": f"pulse-{name}"}]
    address = f"pulse_{name.replace('-', '_')}_pulse:Pulse"
    assert row["problem"].startswith(f"profile 'pulse-{name}': {address}: ")
    assert FAULTS[name][1] in row["problem"]


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_plugin_beside_faulty_ones_has_no_problem(checked: tuple[dict[str, Any], int], name: str) -> None:
    row = checked[0][f"sound-{name}"]
    assert (row["problem"], row["entries"]) == (None, [{"kind": "profiles", "name": f"sound-{name}"}])


def test_the_status_is_4_if_a_plugin_is_at_fault(checked: tuple[dict[str, Any], int]) -> None:
    assert checked[1] == 4


def test_a_plugin_that_hangs_is_stopped(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # all of them hang, so the outcome is the same however fast the machine is
    put(site, "hooks-hang", hooks=HANG)
    put(site, "pulse-hangs", pulse=HANG)
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", "1")
    problems = {plugin.distribution: plugin.problem for plugin in checked_plugins()}
    for name in ("hooks-hang", "pulse-hangs"):
        assert "does not end (stopped after 1 s)" in problems[name]


def test_a_module_in_the_current_folder_is_not_executed(
    install: Install, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("test-pulses")
    folder = tmp_path / "data"
    folder.mkdir()
    for name in ("json", "numpy", "signal", "attrs"):
        (folder / f"{name}.py").write_text("import pathlib; pathlib.Path(__file__ + '.executed').touch()")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", GENEROUS)
    assert [plugin.problem for plugin in checked_plugins() if plugin.distribution == "test-pulses"] == [""]
    assert list(folder.glob("*.executed")) == []


@pytest.mark.parametrize("limit", ["-1", "soon", "nan"])
def test_a_time_limit_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, limit: str) -> None:
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", limit)
    with pytest.raises(UsageError, match="SHOCKWAVE_PLUGIN_TIMEOUT must be a number of seconds > 0"):
        time_limit()
