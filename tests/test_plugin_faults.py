"""A plugin at fault is reported, and stops only a scene that needs it; whatever the fault is."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from shockwave import registry
from shockwave.cli import main

if TYPE_CHECKING:
    from conftest import Install

HOOK = "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_profiles({arguments}):\n    {body}\n"

#: Code that fails on import, and what is reported of it.
ON_IMPORT = {
    "raises": ("raise RuntimeError('out of order')", "RuntimeError: out of order"),
    "is no Python": ("def (:", "SyntaxError"),
    "lacks a module": ("import a_module_that_is_nowhere", "ModuleNotFoundError"),
    "exits": ("import sys; sys.exit(3)", "SystemExit: 3"),
}
#: Hooks that are wrong in other ways.
HOOKS = {
    "misspelt": (HOOK.replace("_profiles", "_profile").format(arguments="", body="return []"), "'shockwave_profile'"),
    "takes an argument": (HOOK.format(arguments="scene", body="return []"), "scene"),
    "returns None": (HOOK.format(arguments="", body="return None"), "registers nothing"),
    "returns a text": (HOOK.format(arguments="", body="return 'pulse'"), "must return a list of entries"),
    "returns no entries": (HOOK.format(arguments="", body="return ['pulse']"), "must return entries of strings"),
    "gives no address": (HOOK.format(arguments="", body="return [Entry('a', 'b', 'c')]"), "package.module:Class"),
    "raises in the hook": (HOOK.format(arguments="", body="return 1 / 0"), "ZeroDivisionError"),
    "exits in the hook": (HOOK.format(arguments="", body="raise SystemExit(3)"), "SystemExit: 3"),
}
DECLARED = (
    "from attrs import frozen\nfrom shockwave import ShockProfile, quantity\n"
    "class Base(ShockProfile):\n    def rise(self, s): return s\n    def decay(self, s): return 2 - s\n"
)
WIDTH = "class Pulse(Base):\n    width: float = quantity('{unit}', 'w', above=0{default})\n"
#: Classes that are wrong.
PULSES = {
    "is missing": ("x = 1", "AttributeError"),
    "is no profile": ("class Pulse:\n    pass", "must be a subclass of ShockProfile"),
    "is an instance": ("Pulse = 3.0", "must be a subclass of ShockProfile"),
    "is abstract": (
        "from shockwave import ShockProfile\nclass Pulse(ShockProfile):\n    def rise(self, s): return s",
        "must write decay too",
    ),
    "is undecorated": (DECLARED + WIDTH.format(unit="s", default=""), "decorated with attrs.frozen"),
    "has no ratio": (f"{DECLARED}@frozen\n{WIDTH.format(unit='s', default='')}", "must have duration_ratio"),
}
IN_HOOKS = {f"hooks module {name}": (code, "", cause) for name, (code, cause) in (ON_IMPORT | HOOKS).items()}
IN_PULSE = {f"profile's module {name}": ("", code, cause) for name, (code, cause) in (ON_IMPORT | PULSES).items()}

CHAIN = "chain: {material: paper-steel, diameter: 9.5 mm}\n"
SHOCK = "shock: {profile: PROFILE, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3}\n"


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, profile in (("own", "triangular"), ("foreign", "faulty-pulse")):
        (tmp_path / f"{name}.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", profile))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def install_faulty(install: Install, fault: str) -> str:
    """Install the plugin; gives what is to be reported of it."""
    hooks, pulse, cause = (IN_HOOKS | IN_PULSE)[fault]
    kinds = {
        key: value for key, value in (("hooks", hooks.replace("{", "{{").replace("}", "}}")), ("pulse", pulse)) if value
    }
    install("test-faulty", name="faulty-pulse", **kinds)
    return cause


def rows(capsys: pytest.CaptureFixture[str]) -> dict[str, dict[str, object]]:
    """What `list plugins` says of each plugin."""
    assert main(["list", "plugins", "--json"]) == 0
    return {row["name"]: row for row in json.loads(capsys.readouterr().out)}


@pytest.mark.parametrize("fault", [*IN_HOOKS, *IN_PULSE])
def test_a_fault_stops_the_scene_that_needs_it_with_4(
    install: Install, scene: Path, capsys: pytest.CaptureFixture[str], fault: str
) -> None:
    cause = install_faulty(install, fault)
    install("a-sound", name="one")
    install("z-sound", name="other")
    assert main(["predict", "foreign.yaml"]) == 4
    out, report = capsys.readouterr()
    assert out == ""
    assert report.startswith("foreign.yaml:2:18: shock.profile: ")
    assert "test-faulty" in report
    assert cause in report
    # listing imports the hooks, but no class
    row = rows(capsys)["test-faulty"]
    assert row["version"] == "1.2"
    assert (cause in str(row["problem"])) == (fault in IN_HOOKS) == (row["entries"] == [])
    # others, before and after it in the order in which they are read, go on working
    for name in ("triangular", "one", "other"):
        (scene / "sound.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", name))
        assert main(["predict", "sound.yaml"]) == 0
        assert capsys.readouterr().err == ""


def test_a_built_in_scene_imports_no_plugin(install: Install, scene: Path) -> None:
    install("test-faulty", hooks="import pathlib; pathlib.Path('imported').touch()")
    assert main(["predict", "own.yaml"]) == 0
    assert not (scene / "imported").exists()


@pytest.mark.usefixtures("scene")
def test_output_of_a_plugin_is_not_part_of_a_result(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    returned = "return [Entry('faulty-pulse', 'test_pulses_pulse:Pulse', 'a pulse')]"
    hooks = "print('noise 1')\n" + HOOK.format(arguments="", body=f"print('noise 2'); {returned}")
    install("test-pulses", hooks=hooks, pulse="print('noise 3')\nfrom shockwave import Triangular as Pulse\n")
    assert main(["predict", "foreign.yaml", "--json"]) == 0
    out, report = capsys.readouterr()
    assert json.loads(out)["scenario"] == "foreign"
    assert report.split("\n") == ["noise 1", "noise 2", "noise 3", ""]


@pytest.mark.usefixtures("scene")
def test_a_plugin_for_another_version_is_not_read(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    # reading it would be another fault
    install("test-faulty", hooks="1 / 0", requires="granular-shockwave>=99.1,<100 ; python_version>'3'")
    unmet = "needs granular-shockwave <100,>=99.1 (this is "
    assert str(rows(capsys)["test-faulty"]["problem"]).startswith(unmet)
    assert main(["predict", "foreign.yaml"]) == 4
    assert unmet in capsys.readouterr().err


@pytest.mark.parametrize(
    "requires",
    [
        "granular-shockwave>=0.0.1",
        "granular_shockwave[test]>0",
        "shockwave>=99",
        "granular-shockwave>=99 ; sys_platform=='none'",
        "granular-shockwave>=99 ; extra=='more'",
    ],
)
def test_a_requirement_that_is_met_is_no_fault(install: Install, requires: str) -> None:
    install("test-pulses", name="test-pulse", requires=requires)
    assert registry.find("profiles", "test-pulse").distribution == "test-pulses"


@pytest.mark.usefixtures("scene")
def test_a_clash_is_listed_and_stops_only_scenes_that_use_the_name(
    install: Install, capsys: pytest.CaptureFixture[str]
) -> None:
    install("test-first", name="faulty-pulse")
    install("test-second", name="faulty-pulse")
    clash = "'faulty-pulse' is registered twice, by test-first and test-second"
    assert main(["predict", "foreign.yaml"]) == 4
    assert clash in capsys.readouterr().err
    assert [name for name, row in rows(capsys).items() if clash in str(row["problem"])] == ["test-first", "test-second"]
    assert main(["predict", "own.yaml"]) == 0


def test_a_misspelt_name_is_the_user_s_fault_even_beside_a_faulty_plugin(
    install: Install, scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install_faulty(install, "hooks module raises")
    (scene / "typo.yaml").write_text(CHAIN + SHOCK.replace("PROFILE", "trianguler"))
    assert main(["predict", "typo.yaml"]) == 3
    assert "did you mean 'triangular'?" in capsys.readouterr().err


# ---------------------------------------------------------------- integrators

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
    with pytest.raises(
        registry.PluginError, match=f"is of fixed step, so its entry must say takes='step' .got '{takes}'"
    ):
        registry.load("integrators", "test-methods")


@pytest.mark.parametrize("body", ["raise KeyError('oops')", "return x, v, a, 0.0", "raise SystemExit(0)"])
def test_an_integrator_that_fails_is_the_plugin_s_fault(
    install: Install, scene: Path, capsys: pytest.CaptureFixture[str], body: str
) -> None:
    # what was once settled for a name is kept as long as the process
    name = f"method-{zlib.crc32(body.encode())}"
    install("test-methods", name=name, hooks=METHOD_HOOK.format(takes="step"), pulse=METHOD.format(body=body))
    shock = SHOCK.replace("PROFILE", "triangular")
    for file, block in (("good", "{rtol: 1e-3}"), ("bad", f"{{integrator: {name}}}")):
        (scene / f"{file}.yaml").write_text(f"{CHAIN}{shock}simulate: {block}\n")
    assert main(["simulate", "--primary", "bad.yaml", "good.yaml"]) == 4
    out, report = capsys.readouterr()
    assert "good" in out
    assert f"bad.yaml: integrator {name!r} of test-methods: must not raise (got " in report


# ---------------------------------------------------------------- leaving plugins out


@pytest.mark.usefixtures("scene")
@pytest.mark.parametrize("where", ["before", "behind"])
def test_no_plugins_leaves_all_of_them_out(install: Install, capsys: pytest.CaptureFixture[str], where: str) -> None:
    install("test-pulses", name="faulty-pulse")
    arguments = ["predict", "foreign.yaml"]
    arguments.insert(0 if where == "before" else 2, "--no-plugins")
    assert main(arguments) == 3
    report = capsys.readouterr().err
    assert "plugins that are disabled: " in report
    assert "test-pulses" in report


@pytest.mark.parametrize("names", ["test-pulses", "other, Test.Pulses", "*"])
def test_what_is_disabled_is_not_imported(
    install: Install, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], names: str
) -> None:
    install("test-pulses", hooks="1 / 0")
    monkeypatch.setenv("SHOCKWAVE_DISABLE_PLUGINS", names)
    row = rows(capsys)["test-pulses"]
    assert (row["disabled"], row["problem"]) == (True, None)
