"""A plugin at fault is told, and stops only a scene that needs it; whatever the fault is."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from shockwave import registry
from shockwave.errors import UsageError
from shockwave.registry import isolation

if TYPE_CHECKING:
    from conftest import Install

HOOK = "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_profiles({arguments}):\n    {body}\n"
SEGFAULT = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
ABORT = "import os; os.abort()"
HANG = "import time; time.sleep(600)"
LEAVES = "import os; os._exit(7)"

#: Code that fails on import, and what is told of it.
ON_IMPORT = {
    "raises": ("raise RuntimeError('out of order')", "RuntimeError: out of order"),
    "is no Python": ("def (:", "SyntaxError"),
    "lacks a module": ("import a_module_that_is_nowhere", "ModuleNotFoundError"),
    "exits": ("import sys; sys.exit(3)", "SystemExit: 3"),
    "leaves": (LEAVES, "the process that imports it (status 7)"),
    "hangs": (HANG, "does not end (stopped after"),
    "segfaults": (SEGFAULT, "crashes the process that imports it (SIGSEGV)"),
    "aborts": (ABORT, "crashes the process that imports it (SIGABRT)"),
}
#: Hooks that are wrong in other ways.
HOOKS = {
    "misspelt": (HOOK.replace("_profiles", "_profile").format(arguments="", body="return []"), "shockwave_profile"),
    "takes an argument": (HOOK.format(arguments="scene", body="return []"), "scene"),
    "returns None": (HOOK.format(arguments="", body="return None"), "registers nothing"),
    "returns a text": (HOOK.format(arguments="", body="return 'pulse'"), "must return a list of entries"),
    "returns no entries": (HOOK.format(arguments="", body="return ['pulse']"), "must return entries of strings"),
    "gives no address": (HOOK.format(arguments="", body="return [Entry('a', 'b', 'c')]"), "package.module:Class"),
    "raises in the hook": (HOOK.format(arguments="", body="return 1 / 0"), "ZeroDivisionError"),
}
#: Classes that are wrong.
PULSES = {
    "is missing": ("x = 1", "AttributeError"),
    "is no profile": ("class Pulse:\n    pass", "must be a subclass of ShockProfile"),
    "is an instance": ("Pulse = 3.0", "must be a subclass of ShockProfile"),
    "is abstract": (
        "from shockwave import ShockProfile\nclass Pulse(ShockProfile):\n    def rise(self, s): return s",
        "must write decay too",
    ),
}
IN_HOOKS = {f"hooks module {name}": (code, "", cause) for name, (code, cause) in (ON_IMPORT | HOOKS).items()}
IN_PULSE = {f"profile's module {name}": ("", code, cause) for name, (code, cause) in (ON_IMPORT | PULSES).items()}
EVERY = pytest.mark.parametrize("fault", [*IN_HOOKS, *IN_PULSE])

CHAIN = "chain: {material: paper-steel, diameter: 9.5 mm}\n"
SHOCK = "shock: {profile: PROFILE, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3}\n"


@pytest.fixture(autouse=True)
def short_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    # Enough for an interpreter to start on a busy machine, and little for a plugin that hangs.
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", "4")


def begun(*arguments: str, cwd: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "shockwave", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd)


def ended(process: subprocess.Popen[str]) -> subprocess.CompletedProcess[str]:
    out, told = process.communicate(timeout=60)
    return subprocess.CompletedProcess(process.args, process.returncode, out, told)


def shockwave(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return ended(begun(*arguments, cwd=cwd))


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    for name, profile in (("own", "triangular"), ("foreign", "faulty-pulse")):
        (tmp_path / f"{name}.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", profile))
    return tmp_path


def install_faulty(install: Install, fault: str) -> str:
    """Install the plugin; what is to be told of it."""
    hooks, pulse, cause = (IN_HOOKS | IN_PULSE)[fault]
    kinds = {
        key: value for key, value in (("hooks", hooks.replace("{", "{{").replace("}", "}}")), ("pulse", pulse)) if value
    }
    install("test-faulty", name="faulty-pulse", **kinds)
    return cause


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What a scene that needs no plugin gives without any."""
    folder = tmp_path_factory.mktemp("plain")
    (folder / "own.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", "triangular"))
    return shockwave("predict", "own.yaml", "--json", "--no-plugins", cwd=folder).stdout


@EVERY
def test_a_fault_is_reported_contained_and_ends_with_4(install: Install, scene: Path, answer: str, fault: str) -> None:
    cause = install_faulty(install, fault)
    commands = (
        ("list", "plugins", "--check", "--json"),
        ("predict", "own.yaml", "--json"),
        ("predict", "foreign.yaml"),
    )
    listed, own, needs = map(ended, [begun(*command, cwd=scene) for command in commands])

    (row,) = [row for row in json.loads(listed.stdout) if row["name"] == "test-faulty"]
    assert (row["version"], listed.returncode, listed.stderr) == ("1.2", 4, "")
    assert cause in row["problem"]

    assert (own.returncode, own.stdout, own.stderr) == (0, answer, "")

    assert (needs.returncode, needs.stdout) == (4, "")
    assert needs.stderr.startswith("foreign.yaml:2:18: shock.profile: ")
    assert "test-faulty" in needs.stderr
    assert cause in needs.stderr
    assert "Traceback" not in needs.stderr


@pytest.mark.parametrize("fault", ["hooks module hangs", "hooks module segfaults", "hooks module leaves"])
def test_another_plugin_goes_on_working(install: Install, scene: Path, fault: str) -> None:
    # one before and one after, in the order in which they are read
    install("a-sound", name="first-pulse")
    install_faulty(install, fault)
    install("z-sound", name="last-pulse")
    for name in ("first-pulse", "last-pulse"):
        (scene / f"{name}.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", name))
    done = shockwave("predict", "first-pulse.yaml", "last-pulse.yaml", cwd=scene)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_plugin_for_another_version_is_not_read(install: Install, scene: Path) -> None:
    install("test-faulty", name="faulty-pulse", requires="granular-shockwave>=99.1,<100 ; python_version>'3'")
    (plugin,) = [plugin for plugin in registry.plugins() if plugin.distribution == "test-faulty"]
    assert plugin.problem.startswith("needs granular-shockwave <100,>=99.1 (this is ")
    needs = shockwave("predict", "foreign.yaml", cwd=scene)
    assert needs.returncode == 4
    assert "needs granular-shockwave <100,>=99.1" in needs.stderr


@pytest.mark.parametrize(
    "requires",
    [
        "granular-shockwave>=0.0.1",
        "granular-shockwave",
        "granular_shockwave[test]>0",
        "granular-shockwave-other>=99",
        "shockwave>=99",
    ],
)
def test_a_version_that_fits_is_no_fault(install: Install, requires: str) -> None:
    install("test-pulses", name="test-pulse", requires=requires)
    assert registry.find("profiles", "test-pulse").distribution == "test-pulses"


def test_a_clash_is_told_by_the_list_and_stops_only_who_uses_the_name(install: Install, scene: Path) -> None:
    install("test-first", name="faulty-pulse")
    install("test-second", name="faulty-pulse")
    needs = shockwave("predict", "foreign.yaml", cwd=scene)
    told = "'faulty-pulse' is registered twice, by test-first and test-second"
    assert needs.returncode == 4
    assert told in needs.stderr
    listed = shockwave("list", "plugins", cwd=scene)
    assert (listed.returncode, listed.stdout.count(told)) == (0, 2)
    assert shockwave("predict", "own.yaml", cwd=scene).returncode == 0


def test_a_misspelt_name_is_the_user_s_fault_even_beside_a_faulty_plugin(install: Install, scene: Path) -> None:
    install_faulty(install, "hooks module raises")
    (scene / "typo.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", "trianguler"))
    told = shockwave("predict", "typo.yaml", cwd=scene)
    assert told.returncode == 3
    assert "did you mean 'triangular'?" in told.stderr


def test_a_scene_can_require_a_plugin_that_does_not_work(install: Install, scene: Path) -> None:
    install_faulty(install, "hooks module raises")
    (scene / "requires.yaml").write_text("requires: [Test_Faulty]\n" + CHAIN + SHOCK.replace("PROFILE", "triangular"))
    told = shockwave("predict", "requires.yaml", cwd=scene)
    assert told.returncode == 4
    assert "requires.yaml:1:12: requires[0]: must be a plugin that works (got RuntimeError" in told.stderr


# ---------------------------------------------------------------- disabling


@pytest.mark.parametrize("where", ["before", "behind"])
def test_no_plugins_leaves_all_of_them_out(install: Install, scene: Path, where: str) -> None:
    install("test-pulses", name="faulty-pulse")
    arguments = ["predict", "foreign.yaml"]
    arguments.insert(0 if where == "before" else 2, "--no-plugins")
    told = shockwave(*arguments, cwd=scene)
    assert told.returncode == 3
    assert "plugins that are disabled: " in told.stderr
    assert "test-pulses" in told.stderr


@pytest.mark.parametrize("names", ["test-pulses", "other, Test.Pulses", "*"])
def test_plugins_are_disabled_by_name(
    install: Install, scene: Path, monkeypatch: pytest.MonkeyPatch, names: str
) -> None:
    install("test-pulses", name="faulty-pulse", hooks=HANG)
    monkeypatch.setenv("SHOCKWAVE_DISABLE_PLUGINS", names)
    # what is disabled is not read: that would not end
    told = shockwave("list", "plugins", "--json", cwd=scene)
    (row,) = [row for row in json.loads(told.stdout) if row["name"] == "test-pulses"]
    assert (row["disabled"], row["problem"], told.returncode) == (True, None, 0)


def test_one_disabled_plugin_leaves_another_in_use(
    install: Install, scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("test-pulses", name="faulty-pulse")
    monkeypatch.setenv("SHOCKWAVE_DISABLE_PLUGINS", "test-others")
    assert shockwave("predict", "foreign.yaml", cwd=scene).returncode == 0


# ---------------------------------------------------------------- what is kept


def test_what_was_read_is_read_again_only_after_a_change(
    install: Install, site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = install("test-pulses", name="first-name")
    registry.load("profiles", "first-name")
    registry.forget()
    with monkeypatch.context() as patch:
        patch.setattr(isolation, "_begun", lambda _: pytest.fail("another process was begun"))
        registry.load("profiles", "first-name")
    hooks = site / f"{module}.py"
    hooks.write_text(hooks.read_text().replace("first-name", "another-name"))
    registry.forget()
    assert [entry.name for _, entry in registry.plugins()[-1].entries] == ["another-name"]


def test_a_fault_that_was_mended_is_not_kept(install: Install, site: Path) -> None:
    module = install("test-pulses", name="test-pulse", pulse="import a_module_that_is_nowhere")
    with pytest.raises(registry.PluginError, match="a_module_that_is_nowhere"):
        registry.load("profiles", "test-pulse")
    (site / "a_module_that_is_nowhere.py").write_text("")
    pulse = site / f"{module}_pulse.py"
    pulse.write_text(f"{pulse.read_text()}\nfrom shockwave.profiles.triangular import Triangular as Pulse\n")
    registry.forget()
    assert registry.load("profiles", "test-pulse").__name__ == "Triangular"


@pytest.mark.parametrize("text", ["", "{", "[]", '{"answers": 3}', '{"place": 1, "answers": {}}'])
def test_a_damaged_memory_is_passed_over(install: Install, cache_folder: Path, text: str) -> None:
    install("test-pulses", name="test-pulse")
    registry.plugins()
    (file,) = cache_folder.glob("plugins-*.json")
    file.write_text(text)
    registry.forget()
    assert registry.find("profiles", "test-pulse").distribution == "test-pulses"


def test_without_a_place_to_keep_it_everything_works(
    install: Install, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: tmp_path / "file" / "folder")
    install("test-pulses", name="test-pulse")
    assert registry.load("profiles", "test-pulse").__name__ == "Pulse"


@pytest.mark.parametrize("limit", ["0", "-1", "soon", "inf", "nan"])
def test_a_time_limit_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, limit: str) -> None:
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", limit)
    with pytest.raises(UsageError, match="SHOCKWAVE_PLUGIN_TIMEOUT must be a number of seconds > 0"):
        isolation.time_limit()


def test_what_a_plugin_prints_does_not_reach_the_user(install: Install, scene: Path) -> None:
    install(
        "test-pulses", name="faulty-pulse", hooks="print('noise')\n" + HOOK.format(arguments="", body="return 1 / 0")
    )
    told = shockwave("list", "plugins", cwd=scene)
    assert "noise" not in told.stdout + told.stderr
