"""Built-ins and plugins: found by name, imported on use; a faulty plugin stops only a scene that needs it."""

from __future__ import annotations

import re
import sys
import zlib
from pathlib import Path
from typing import Any

import pytest

from conftest import HOOKS as SOUND_HOOKS
from conftest import PULSE, ROOT, Install
from shockwave.base.errors import PluginError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.registry import built_ins, registry
from support.command_line import scenario, shockwave

BUILT_IN = {
    "profiles": "power-law",
    "integrators": "dop853",
    "quadratures": "gauss-legendre",
    "materials": "paper-steel",
}
EVERY_KIND = pytest.mark.parametrize("kind", BUILT_IN)

CHAIN = "chain: {material: paper-steel, diameter: 9.5 mm}"
SHOCK = "shock: {profile: PROFILE, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3}"


# ---------------------------------------------------------------- names


@EVERY_KIND
def test_every_built_in_has_a_summary_and_can_be_loaded(kind: str) -> None:
    for entry in built_ins.ENTRIES[kind]:
        assert entry.summary
        assert registry.load(kind, entry.name) is not None


@EVERY_KIND
def test_the_error_for_an_unknown_name_states_known_names_and_the_nearest(kind: str) -> None:
    near = BUILT_IN[kind] + "x"
    with pytest.raises(UnknownNameError) as caught:
        registry.find(kind, near)
    message = str(caught.value)
    assert message.startswith(f"unknown {registry.KINDS[kind]} (got {near!r}; did you mean {BUILT_IN[kind]!r}? known: ")
    known = [entry.name for entry in registry.entries(kind)]
    shortened = len(known) > 20
    assert shortened or all(name in message for name in known)
    assert message.endswith(f"; `shockwave list {kind}` shows all)") == shortened


def test_case_does_not_matter_in_a_name(install: Install) -> None:
    install("test-pulses", name="Test-Pulse")
    assert registry.find("profiles", "test-pulse").name == "Test-Pulse"
    assert registry.find("materials", "PAPER-steel").name == "paper-steel"


def test_a_plugin_is_found_as_installed(install: Install) -> None:
    module = install("test-pulses", name="test-pulse", version="3.4.5")
    entry = registry.find("profiles", "test-pulse")
    assert entry == Entry("test-pulse", f"{module}_pulse:Pulse", "a pulse", distribution="test-pulses")
    # the module of hooks alone is imported before the name is used
    assert {module, f"{module}_pulse"} & set(sys.modules) == {module}
    assert registry.load("profiles", "test-pulse") is sys.modules[f"{module}_pulse"].Pulse


# ---------------------------------------------------------------- faults

HOOK = "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_profiles({arguments}):\n    {body}\n"

#: Code that fails on import, and what is reported of it.
ON_IMPORT = {
    "raises": ("raise RuntimeError('out of order')", "RuntimeError: out of order"),
    "is no Python": ("def (:", "SyntaxError"),
    "lacks a module": ("import a_module_that_is_nowhere", "ModuleNotFoundError"),
    "exits": ("import sys; sys.exit(3)", "SystemExit: 3"),
}
#: Hooks that are wrong in other ways: their arguments and body, and what is reported of them.
HOOKS = {
    "takes an argument": ("scene", "return []", "scene"),
    "returns None": ("", "return None", "registers nothing"),
    "returns a text": ("", "return 'pulse'", "must return a list of entries"),
    "raises in the hook": ("", "return 1 / 0", "ZeroDivisionError"),
    "takes a name": ("", "return [Entry('triangular', 'a:B', 'c')]", "profile 'triangular' is a built-in name"),
}
MISSPELT = HOOK.replace("_profiles", "_profile").format(arguments="", body="return []")
#: Classes that are wrong.
PULSES = {
    "is missing": ("x = 1", "AttributeError"),
    "is no profile": ("class Pulse:\n    pass", "must be a subclass of ShockProfile"),
    "is an instance": ("Pulse = 3.0", "must be a subclass of ShockProfile"),
    "is abstract": ("from shockwave import ShockProfile\nclass Pulse(ShockProfile): pass", "must also define decay"),
    "is undecorated": (
        "from shockwave import Triangular, quantity\nclass Pulse(Triangular):\n    width: float = quantity('s', 'w')",
        "decorated with attrs.frozen",
    ),
}
IN_HOOKS = {f"hooks module {name}": (code, "", cause) for name, (code, cause) in ON_IMPORT.items()}
IN_HOOKS |= {
    f"hooks module {name}": (HOOK.format(arguments=arguments, body=body), "", cause)
    for name, (arguments, body, cause) in HOOKS.items()
}
IN_HOOKS["hooks module is misspelt"] = (MISSPELT, "", "'shockwave_profile'")
IN_PULSE = {f"profile's module {name}": ("", code, cause) for name, (code, cause) in (ON_IMPORT | PULSES).items()}


pytestmark = pytest.mark.usefixtures("folder")


def scene(profile: str = "faulty-pulse", *more: str, chain: str = CHAIN, name: str = "scene") -> Path:
    """A scenario of a shock with this profile."""
    return scenario(Path(), chain, SHOCK.replace("PROFILE", profile), *more, name=name)


def install_faulty(install: Install, fault: str) -> str:
    """Install the plugin; gives what is to be reported of it."""
    hooks, pulse, cause = (IN_HOOKS | IN_PULSE)[fault]
    given = {"hooks": hooks.replace("{", "{{").replace("}", "}}"), "pulse": pulse}
    install("test-faulty", name="faulty-pulse", **{key: value for key, value in given.items() if value})
    return cause


def listed() -> dict[str, dict[str, Any]]:
    """The answer of `list plugins` on each plugin."""
    answer = shockwave("list", "plugins", "--json")
    assert answer.status == 0
    return {row["name"]: row for row in answer.document}


@pytest.mark.parametrize("fault", [*IN_HOOKS, *IN_PULSE])
def test_a_fault_stops_the_scene_that_needs_it_with_4(install: Install, fault: str) -> None:
    cause = install_faulty(install, fault)
    install("a-sound", name="one")
    install("z-sound", name="other")
    answer = shockwave("predict", scene())
    assert (answer.status, answer.out) == (4, "")
    assert answer.err.startswith("scene.yaml:2:18: shock.profile: ")
    assert "test-faulty" in answer.err
    assert cause in answer.err
    # listing imports the hooks, but no class
    row = listed()["test-faulty"]
    assert (cause in str(row["problem"])) == (fault in IN_HOOKS) == (row["entries"] == [])
    # others, before and after it in the order in which they are read, go on working
    for name in ("triangular", "one", "other"):
        answer = shockwave("predict", scene(name))
        assert (answer.status, answer.err) == (0, "")


def test_output_of_a_plugin_is_not_part_of_a_result(install: Install) -> None:
    returned = "return [Entry('faulty-pulse', 'test_pulses_pulse:Pulse', 'a pulse')]"
    hooks = "print('noise 1')\n" + HOOK.format(arguments="", body=f"print('noise 2'); {returned}")
    install("test-pulses", hooks=hooks, pulse="print('noise 3')\nfrom shockwave import Triangular as Pulse\n")
    answer = shockwave("predict", scene(), "--json")
    assert answer.document["scenario"] == "scene"
    assert answer.err.split("\n") == ["noise 1", "noise 2", "noise 3", ""]


def test_a_name_of_two_plugins_stops_only_scenes_with_it(install: Install) -> None:
    install("test-first", name="faulty-pulse")
    install("test-second", name="faulty-pulse")
    answer = shockwave("predict", scene())
    assert answer.status == 4
    assert "'faulty-pulse' is registered twice, by test-first and test-second" in answer.err
    assert shockwave("predict", scene("triangular")).status == 0


def test_a_typing_error_is_reported_beside_a_faulty_plugin(install: Install) -> None:
    install_faulty(install, "hooks module raises")
    answer = shockwave("predict", scene("trianguler"))
    assert answer.status == 3
    assert "did you mean 'triangular'?" in answer.err


METHOD = """
from attrs import define
from shockwave.engine.one_step import Attempt, OneStep

@define
class Method(OneStep):
    name = "test-method"
    order = 1
    adaptive = False

    def attempt(self, acceleration, time, size, x, v, a):
        {body}
"""
METHOD_HOOK = (
    "from shockwave.hooks import Entry, hookimpl\n@hookimpl\ndef shockwave_integrators():\n"
    "    return [Entry('{{name}}', '{{module}}_pulse:Method', 'a method', takes='{takes}')]\n"
)


@pytest.mark.parametrize("takes", ["", "rtol"])
def test_an_integrator_must_state_its_setting(install: Install, takes: str) -> None:
    install("test-methods", hooks=METHOD_HOOK.format(takes=takes), pulse=METHOD.format(body="pass"))
    with pytest.raises(PluginError, match="must be registered with takes='step'"):
        registry.load("integrators", "test-methods")


@pytest.mark.parametrize("body", ["raise KeyError('oops')", "return x, v, a, 0.0", "raise SystemExit(0)"])
def test_an_integrator_that_fails_is_an_error_of_its_plugin(install: Install, body: str) -> None:
    # what was once settled for a name is kept as long as the process
    name = f"method-{zlib.crc32(body.encode())}"
    install("test-methods", name=name, hooks=METHOD_HOOK.format(takes="step"), pulse=METHOD.format(body=body))
    good = scene("triangular", "simulate: {rtol: 1e-3}", name="good")
    bad = scene("triangular", f"simulate: {{integrator: {name}}}", name="bad")
    answer = shockwave("simulate", "--primary", bad, good)
    assert answer.status == 4
    assert "good" in answer.out
    assert f"bad.yaml: integrator {name!r} of test-methods: must not raise (got " in answer.err


DERIVED = """
from attrs import define
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.scipy_integrators import Dop853

@define
class Method({base}):
    name = "derived"
    {body}
"""


@pytest.mark.parametrize("base", ["Rkn86", "Dop853"])
@pytest.mark.parametrize(
    ("features", "status", "message"),
    [
        ("", 4, "its own step"),
        (", granules: 8, end: {wall: same}", 4, "its own step"),
        (", granules: 8, damping: {model: dashpot, coefficient: 1}", 3, "simulate.integrator: must be dop853"),
    ],
    ids=["endless", "walled", "damped"],
)
def test_a_plugin_derived_from_a_built_in_method_takes_its_own_steps(
    install: Install, base: str, features: str, status: int, message: str
) -> None:
    name = f"derived-{base.lower()}-{len(features)}"
    body = "def steps(self, *arguments):\n        raise RuntimeError('its own step')"
    pulse = DERIVED.format(base=base, body=body)
    install("test-derived", name=name, hooks=METHOD_HOOK.format(takes="rtol"), pulse=pulse)
    chain = CHAIN.replace("}", features + "}")
    answer = shockwave("simulate", "--primary", scene("triangular", f"simulate: {{integrator: {name}}}", chain=chain))
    assert answer.status == status
    assert message in answer.err


# ---------------------------------------------------------------- commands

COMMAND_HOOK = """
from shockwave.hooks import Entry, hookimpl

@hookimpl
def shockwave_commands():
    return [Entry("{name}", "{module}_pulse:run", "a command")]
"""
RUN = "from shockwave import UsageError\ndef run(arguments):\n    {body}\n"


@pytest.mark.parametrize(
    ("body", "status", "text"),
    [
        ("print(arguments)", 0, "['--depth', '3', 'x.yaml']"),
        ("return len(arguments)", 3, ""),
        ("raise SystemExit(2)", 2, ""),
        ("raise UsageError('--depth: must be left out')", 2, "--depth: must be left out"),
        ("raise OSError('oops')", 4, "command 'dig' of test-dig: must not raise (got OSError: oops)"),
        ("return 'done'", 4, "command 'dig' of test-dig: must not raise (got ValueError: "),
    ],
    ids=["prints", "status", "exit", "error", "fails", "no status"],
)
def test_a_command_of_a_plugin_gets_its_arguments(body: str, status: int, text: str, install: Install) -> None:
    install("test-dig", hooks=COMMAND_HOOK, pulse=RUN.format(body=body), name="dig")
    answer = shockwave("dig", "--depth", "3", "x.yaml")
    assert answer.status == status
    assert text in answer.out + answer.err


@pytest.mark.parametrize("pulse", ["1 / 0", "run = 5"], ids=["import", "no function"])
def test_a_faulty_command_is_an_error_of_its_plugin(pulse: str, install: Install) -> None:
    install("test-dig", hooks=COMMAND_HOOK, pulse=pulse, name="dig")
    answer = shockwave("dig")
    assert answer.status == 4
    assert "plugin test-dig is faulty: command 'dig': test_dig_pulse:run: " in answer.err


def test_known_commands_and_help_load_no_plugin(install: Install) -> None:
    install("test-dig", hooks="raise SystemExit(9)")
    assert [shockwave(*arguments).status for arguments in (["--help"], ["new", "--help"], ["new"])] == [0, 0, 0]
    assert "test_dig" not in sys.modules
    answer = shockwave("tunnel")
    assert answer.status == 4
    assert "unknown command (got 'tunnel'; plugin test-dig is faulty: SystemExit: 9)" in answer.err


@pytest.mark.parametrize("before", [[], ["--no-plugins"]], ids=["unknown", "disabled"])
def test_an_unknown_command_is_an_error_of_usage(before: list[str], install: Install) -> None:
    install("test-dig", hooks=COMMAND_HOOK, pulse=RUN.format(body="return 0"), name="dig" if before else "delve")
    answer = shockwave(*before, "dig")
    assert answer.status == 2
    assert "unknown command (got 'dig'; " in answer.err


@pytest.mark.usefixtures("patch")
@pytest.mark.parametrize("before", [[], ["--no-plugins"]], ids=["missing", "disabled"])
def test_explore_names_what_to_install(before: list[str]) -> None:
    answer = shockwave(*before, "explore", "--port", "0")
    assert answer.status == 2
    assert answer.err.startswith("explore: shockwave-explore must be installed")
    (place,) = re.findall(r"python -m pip install (\S+?)\)", answer.err)
    assert (ROOT / place / "pyproject.toml").is_file()


# ---------------------------------------------------------------- leaving plugins out


@pytest.mark.parametrize("place", [0, 2], ids=["before", "after"])
def test_no_plugins_leaves_all_of_them_out(install: Install, place: int) -> None:
    install("test-pulses", name="faulty-pulse")
    arguments: list[object] = ["predict", scene()]
    arguments.insert(place, "--no-plugins")
    answer = shockwave(*arguments)
    assert answer.status == 3
    assert "disabled plugins: " in answer.err


@pytest.mark.parametrize("names", ["test-pulses", "other, Test.Pulses", "*"])
def test_disabled_plugins_are_not_imported(install: Install, monkeypatch: pytest.MonkeyPatch, names: str) -> None:
    install("test-pulses", hooks="1 / 0")
    monkeypatch.setenv("SHOCKWAVE_DISABLE_PLUGINS", names)
    row = listed()["test-pulses"]
    assert (row["disabled"], row["problem"]) == (True, None)


# ---------------------------------------------------------------- list plugins --check

#: Code at the head of a module, and the problem that the check reports, if any.
CHECKED = {
    "sound": ("", ""),
    "prints": ("import os; print('noise'); os.write(1, b'noise')", ""),
    "raises": ("raise RuntimeError('out of order')", "RuntimeError: out of order"),
    "exits": ("import sys; sys.exit(3)", "SystemExit: 3"),
}


@pytest.mark.parametrize("place", ["hooks", "pulse"])
def test_the_check_imports_everything_that_plugins_register(place: str, install: Install) -> None:
    sound = {"hooks": SOUND_HOOKS, "pulse": PULSE}
    for name, (code, _) in CHECKED.items():
        install(f"x-{name}", **{place: f"{code}\n{sound[place]}"})
    answer = shockwave("list", "plugins", "--check", "--json")
    assert answer.status == 4
    rows = {row["name"].removeprefix("x-"): row for row in answer.document}
    for name, (_, problem) in CHECKED.items():
        assert problem in (rows[name]["problem"] or "")
        assert bool(rows[name]["problem"]) == bool(problem)
    assert rows["sound"]["entries"] == [{"kind": "profiles", "name": "x-sound"}]
