"""Reading plugins: what one does to the process that reads it is not told of another, and nothing stale is used."""

from __future__ import annotations

import importlib
import sys
import zipfile
import zlib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from shockwave import registry
from shockwave.errors import PluginError
from shockwave.registry import isolation

if TYPE_CHECKING:
    from conftest import Install

GOOD_HOOK = (
    "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_profiles():\n"
    "    return [Entry('{name}', '{module}_pulse:Pulse', 'a pulse')]\n"
)


@pytest.fixture(autouse=True)
def short_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHOCKWAVE_PLUGIN_TIMEOUT", "4")


def plugin(distribution: str) -> registry.Plugin:
    (found,) = [plugin for plugin in registry.plugins() if plugin.distribution == distribution]
    return found


#: What a module of hooks may do to the process that reads it, and to those that are read after it.
HARMS = {
    "clears the path": "import sys; sys.path.clear()",
    "forks": "import os; os.fork()",
    "spoils json": "import json; json.dumps = lambda *_, **__: 'noise'",
    "spoils imports": "import sys; sys.meta_path.insert(0, type('No', (), {{'find_spec': lambda *_: 1 / 0}}))",
    "closes files": "import os; os.closerange(3, 64)",
    "prints": "import os; os.write(1, b'noise')",
    "runs on": "import threading; threading.Thread(target=threading.Event().wait).start()",
    "changes the folder": "import os; os.chdir('/')",
}


@pytest.mark.parametrize("harm", HARMS)
def test_what_one_plugin_does_is_not_told_of_another(install: Install, harm: str) -> None:
    install("a-harm", hooks=f"{HARMS[harm]}\n{GOOD_HOOK}")
    install("b-sound")
    registry.forget()
    assert plugin("b-sound").problem == ""
    assert registry.load("profiles", "b-sound").__name__ == "Pulse"


@pytest.mark.parametrize(
    ("file", "text", "problem"),
    [
        ("entry_points.txt", b"[shockwave]\nno equals sign\n", "entry points cannot be read"),
        ("entry_points.txt", b"[shockwave]\na = \xff\n", "entry points cannot be read"),
        ("METADATA", b"Name: a-\xff\n", "metadata cannot be read"),
        ("entry_points.txt", b"[shockwave]\na = a_damaged:hook\n", "must name a module (got a_damaged:hook)"),
    ],
    ids=["no-value", "no-text", "metadata", "attribute"],
)
def test_damaged_metadata_are_told_of_their_distribution(
    install: Install, site: Path, file: str, text: bytes, problem: str
) -> None:
    install("a-damaged")
    install("b-sound")
    (site / "a_damaged-1.2.dist-info" / file).write_bytes(text)
    registry.forget()
    assert any(problem in found.problem for found in registry.plugins())
    assert plugin("b-sound").problem == ""


@pytest.mark.parametrize("change", ["leaves", "hangs"])
def test_a_helper_that_changes_is_noticed(install: Install, site: Path, change: str) -> None:
    helper = site / "a_helper_of_it.py"
    helper.write_text("")
    install("test-pulses", pulse="import a_helper_of_it\nfrom shockwave import Triangular as Pulse\n")
    registry.load("profiles", "test-pulses")
    helper.write_text({"leaves": "import os; os._exit(3)", "hangs": "import time; time.sleep(600)"}[change])
    del sys.modules["test_pulses_pulse"], sys.modules["a_helper_of_it"]
    registry.forget()
    with pytest.raises(PluginError, match={"leaves": "status 3", "hangs": "does not end"}[change]):
        registry.load("profiles", "test-pulses")


def test_that_a_plugin_does_not_end_is_asked_again_when_it_changes(
    install: Install, site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = install("test-pulses", hooks="import time; time.sleep(600)")
    assert "does not end" in plugin("test-pulses").problem
    registry.forget()
    with monkeypatch.context() as patch:
        patch.setattr(isolation, "_begun", lambda _: pytest.fail("asked again, which takes long"))
        assert "does not end" in plugin("test-pulses").problem
    (site / f"{module}.py").write_text(GOOD_HOOK.format(name="test-pulse", module=module))
    registry.forget()
    assert plugin("test-pulses").problem == ""


def test_a_plugin_in_an_archive_can_be_used(site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    archive = tmp_path / "plugins.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("zipped.py", GOOD_HOOK.format(name="zipped-pulse", module="zipped"))
        file.writestr("zipped_pulse.py", "from shockwave import Triangular as Pulse\n")
        file.writestr("zipped-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: zipped\nVersion: 1.0\n")
        file.writestr("zipped-1.0.dist-info/entry_points.txt", "[shockwave]\nz = zipped\n")
    monkeypatch.syspath_prepend(archive)
    registry.forget()
    importlib.invalidate_caches()
    assert registry.load("profiles", "zipped-pulse").__name__ == "Triangular"


def test_a_path_that_is_no_text_is_passed_over(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    install("test-pulses")
    monkeypatch.setattr(sys, "path", [*sys.path, Path("/nowhere")])
    registry.forget()
    assert plugin("test-pulses").problem == ""


@pytest.mark.parametrize(
    "requires", ["granular-shockwave>=99 ; sys_platform=='none'", "granular-shockwave>=99 ; extra=='more'"]
)
def test_a_requirement_of_another_place_does_not_count(install: Install, requires: str) -> None:
    install("test-pulses", requires=requires)
    assert plugin("test-pulses").problem == ""


def test_two_distributions_with_the_same_entry_point_are_both_read(install: Install, site: Path) -> None:
    install("a-one", name="one-pulse")
    install("b-two", name="two-pulse")
    (site / "b_two-1.2.dist-info" / "entry_points.txt").write_text("[shockwave]\na-one = a_one\n")
    registry.forget()
    with pytest.raises(PluginError, match=r"registered twice, by (a-one and b-two|b-two and a-one)"):
        registry.find("profiles", "one-pulse")


@pytest.mark.parametrize("executable", ["/bin/true", "/bin/echo", "/nowhere/python"])
def test_an_interpreter_that_is_none_is_told(
    install: Install, monkeypatch: pytest.MonkeyPatch, executable: str
) -> None:
    install("test-pulses")
    monkeypatch.setattr(sys, "executable", executable)
    registry.forget()
    with pytest.raises(PluginError, match="plugins cannot be read"):
        registry.plugins()


def test_without_a_home_everything_works(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless(*_: object, **__: object) -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr("platformdirs.user_cache_path", homeless)
    install("test-pulses")
    assert registry.load("profiles", "test-pulses").__name__ == "Pulse"


# ---------------------------------------------------------------- what is checked of a class

METHOD = """
from attrs import define
from shockwave.simulation.one_step import Attempt, OneStep

@define
class Method(OneStep):
    name = "test-method"
    order = 1
    adaptive = False
    symplectic = False

    def attempt(self, acceleration, time, size, x, v, a):
        {body}
"""
METHOD_HOOK = (
    "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_integrators():\n"
    "    return [Entry('{{name}}', '{{module}}_pulse:Method', 'a method', takes='{takes}')]\n"
)


@pytest.mark.parametrize("takes", ["", "rtol", "steps"])
def test_an_integrator_must_say_what_it_takes(install: Install, takes: str) -> None:
    install("test-methods", hooks=METHOD_HOOK.format(takes=takes), pulse=METHOD.format(body="pass"))
    with pytest.raises(PluginError, match=f"is of fixed step, so its entry must say takes='step' .got '{takes}'"):
        registry.load("integrators", "test-methods")


@pytest.mark.parametrize("body", ["raise KeyError('oops')", "return x, v, a, 0.0", "raise SystemExit(0)"])
def test_an_integrator_that_fails_is_the_plugin_s_fault(
    install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str], body: str
) -> None:
    from shockwave.cli import main

    # what was once settled for a name is kept as long as the process
    name = f"method-{zlib.crc32(body.encode())}"
    install("test-methods", name=name, hooks=METHOD_HOOK.format(takes="step"), pulse=METHOD.format(body=body))
    chain = "chain: {material: paper-steel, diameter: 9.5 mm}\n"
    shock = "shock: {profile: triangular, peak_force: 1 N, rise_time: 5 us, duration_ratio: 2}\n"
    for file, block in (("good", "{rtol: 1e-3}"), ("bad", f"{{integrator: {name}}}")):
        (tmp_path / f"{file}.yaml").write_text(f"{chain}{shock}simulate: {block}\n")
    assert main(["simulate", "--primary", str(tmp_path / "bad.yaml"), str(tmp_path / "good.yaml")]) == 4
    out, told = capsys.readouterr()
    assert "good" in out
    assert f"bad.yaml: integrator {name!r} of test-methods: must not raise (got " in told


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("@frozen\nclass Pulse(Base):\n    width: float = quantity('sekunden', 'w', above=0)", "unit 'sekunden'"),
        ("@frozen\nclass Pulse(Base):\n    width: float = quantity('s', 'w', above=0, default=-1)", "default of field"),
        ("class Pulse(Base):\n    width: float = quantity('s', 'w', above=0)", "decorated with attrs.frozen"),
        ("@frozen\nclass Pulse(Base):\n    width: float = quantity('s', 'w', above=0)", "must have duration_ratio"),
    ],
    ids=["unit", "default", "undecorated", "no-ratio"],
)
def test_a_class_that_declares_wrongly_is_told(install: Install, text: str, problem: str) -> None:
    head = (
        "from attrs import frozen\nfrom shockwave import ShockProfile, quantity\n"
        "class Base(ShockProfile):\n    def rise(self, s): return s\n    def decay(self, s): return 2 - s\n"
    )
    install("test-pulses", pulse=head + text + "\n")
    with pytest.raises(PluginError, match=problem):
        registry.load("profiles", "test-pulses")
