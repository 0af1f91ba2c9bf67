"""The schema and the templates of what a plugin brings: its parameters work like shockwave's own."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

from shockwave.base.errors import PluginError, ScenarioError
from shockwave.scenario.schema import schema
from shockwave.scenario.template import template
from support.fake_distributions import install
from support.pages import workplace
from support.scenario_texts import CHAIN, load, schema_faults

HOOKS = """
from shockwave.hooks import Entry, hookimpl

@hookimpl
def shockwave_profiles():
    return [Entry(name, f"{module}.pulses:{{name.title()}}", f"a pulse, {{name}}") for name in {names}]
"""
PULSES = """
import math
from typing import Literal

import attrs
from attrs import frozen
from shockwave import InvalidValueError, quantity
from shockwave.base.quantity_fields import Declaration
from shockwave.profiles.triangular import Triangular

KNOTS = Declaration("s", "knots", above=0, samples=True, optional=True)

@frozen(kw_only=True)
class Declared(Triangular):
    delay: float = quantity("s", "a delay", above=1e-3, at_most=5e-3)
    # of the same name as an option, and nothing to do with it
    step: float = quantity("m", "a step", default=None)
    knots: tuple = attrs.field(default=None, converter=attrs.converters.optional(tuple), metadata={"shockwave": KNOTS})
    duration_ratio: float = quantity("", "n", above=20, default=30)

    def __attrs_post_init__(self) -> None:
        if self.step is not None and self.step > 10:
            raise InvalidValueError.of("step", "must be at most 10 m here")

@frozen(kw_only=True)
class Undeclared(Triangular):
    count: int
    kind: Literal["odd", "even"] = "odd"
    weights: tuple[float, ...] = attrs.Factory(tuple)
    flag: bool | None = None
    limit: float = math.inf
    source: str = "me"
    shape: object = attrs.Factory(object)

class Plain(Triangular):
    def __init__(self, power: float = 1.0) -> None:
        super().__init__(duration_ratio=3.0 / power)
"""
PROJECT = '[project]\nname = "{name}"\nversion = "1.0"\nentry-points.shockwave.hooks = "{module}.hooks"\n'
PROFILES = ("declared", "undeclared", "plain")


def _plug(folder: Path, patch: pytest.MonkeyPatch, pulses: str = PULSES) -> Draft7Validator:
    """Put a distribution with profiles on the path; gives the validator that includes it."""
    name, module = "fake-pulses", "fake_pulses"
    package = folder / name / "src" / module
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "hooks.py").write_text(HOOKS.format(module=module, names=PROFILES))
    (package / "pulses.py").write_text(pulses)
    project = folder / name / "pyproject.toml"
    project.write_text(PROJECT.format(name=name, module=module))
    install(folder, project, patch)
    patch.syspath_prepend(folder)
    Draft7Validator.check_schema(schema())
    return Draft7Validator(schema())


def _pulse(profile: str, parameters: str, more: str = "") -> str:
    head = f"shock: {{profile: {profile}, peak_force: 1 N, rise_time: 1 s{more}"
    return f"{CHAIN}{head}, parameters: {{{parameters}}}}}\n"


def _undeclared(parameters: str) -> str:
    return _pulse("undeclared", parameters, ", duration_ratio: 2")


def _parameters_of(validator: Draft7Validator, profile: str) -> Any:
    rules = validator.schema["properties"]["shock"]["allOf"]
    (rule,) = [rule for rule in rules if re.fullmatch(rule["if"]["properties"]["profile"]["pattern"], profile)]
    return rule["then"]["properties"]["parameters"]


@pytest.fixture(scope="class")
def validator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Draft7Validator]:
    """The validator that includes a plugin, which is installed as long."""
    folder = tmp_path_factory.mktemp("plugin")
    with workplace(folder) as patch:
        yield _plug(folder, patch)


#: Scenarios, and values of their profiles.
ADMITTED: dict[str, tuple[str, dict[str, Any]]] = {
    "units": (
        _pulse("declared", "delay: 2 ms, step: null, knots: [1, 20 ms]"),
        {"delay": 2e-3, "step": None, "knots": (1.0, 0.02), "duration_ratio": 30.0},
    ),
    "bare": (_pulse("declared", "delay: 0.002, step: -3", ", duration_ratio: 25"), {"step": -3, "duration_ratio": 25}),
    "kinds": (
        _undeclared("count: '3', kind: even, weights: [1, 50 %], flag: null, limit: 2"),
        {"count": 3, "kind": "even", "weights": (1.0, 0.5), "flag": None, "limit": 2.0},
    ),
    "anything": (_undeclared("count: 3, shape: anything, flag: true"), {"shape": "anything", "flag": True}),
    "plain": (_pulse("plain", "power: 2"), {"duration_ratio": 1.5}),
}
#: Scenarios, the places of their errors below the shock, and whether the schema sees them.
REJECTED = {
    "missing": (_pulse("declared", ""), "parameters", False),
    "range": (_pulse("declared", "delay: 0.001"), "parameters.delay", True),
    "sample": (_pulse("declared", "delay: 2 ms, knots: [1, -2 s]"), "parameters.knots[1]", False),
    "unknown": (_pulse("declared", "delay: 2 ms, dealy: 2"), "parameters", True),
    "constructor": (_pulse("declared", "delay: 2 ms, step: 11"), "parameters.step", False),
    "ratio": (_pulse("declared", "delay: 2 ms", ", duration_ratio: 20"), "duration_ratio", True),
    "half": (_undeclared("count: 1.5"), "parameters.count", True),
    "name": (_undeclared("count: 1, kind: none"), "parameters.kind", True),
    "list": (_undeclared("count: 1, weights: [1, x]"), "parameters.weights[1]", True),
    "number": (_pulse("plain", "power: strong"), "parameters.power", True),
    "key of others": (_pulse("plain", "", ", duration_ratio: 3"), "duration_ratio", True),
}


@pytest.mark.usefixtures("validator")
class TestPlugin:
    @pytest.mark.parametrize("name", ADMITTED)
    def test_its_parameters_are_admitted_and_converted(
        self, tmp_path: Path, validator: Draft7Validator, name: str
    ) -> None:
        text, values = ADMITTED[name]
        assert schema_faults(text, validator) == []
        pulse = load(tmp_path, text).shock.profile
        assert {each: getattr(pulse, each) for each in values} == values

    @pytest.mark.parametrize("name", REJECTED)
    def test_its_bad_parameters_are_rejected_in_their_place(
        self, tmp_path: Path, validator: Draft7Validator, name: str
    ) -> None:
        text, place, seen = REJECTED[name]
        assert schema_faults(text, validator) == ([f"$.shock.{place}"] if seen else [])
        with pytest.raises(ScenarioError) as caught:
            load(tmp_path, text)
        assert caught.value.faults[0].path.startswith(f"shock.{place}")

    def test_other_errors_of_the_constructor_are_errors_of_the_plugin(self, tmp_path: Path) -> None:
        with pytest.raises(PluginError, match=r"profile 'plain' of fake-pulses: .*ZeroDivisionError"):
            load(tmp_path, _pulse("plain", "power: 0"))

    def test_its_parameters_have_meaning_and_default(self, validator: Draft7Validator) -> None:
        forms = _parameters_of(validator, "declared")["properties"]
        assert forms["delay"]["description"] == "a delay, > 0.001 and <= 0.005 s"
        forms = _parameters_of(validator, "undeclared")["properties"]
        stated = {name: form["default"] for name, form in forms.items() if "default" in form}
        assert stated == {"kind": "odd", "source": "me"}

    @pytest.mark.parametrize(
        ("profile", "line"),
        [
            ("declared", "    delay: 0.003  # a delay, > 0.001 and <= 0.005 s"),
            ("declared", "    # knots: [1]  # knots, each > 0 s"),
            ("undeclared", "    kind: odd"),
            ("undeclared", "    # weights: []"),
            ("plain", "  duration: 60 us  # total duration n t0, instead of t0 or n, > 0 s"),
        ],
    )
    def test_templates_hold_its_parameters_and_load(
        self, tmp_path: Path, validator: Draft7Validator, profile: str, line: str
    ) -> None:
        text = template(profile, full=True)
        assert line in text.splitlines()
        assert schema_faults(text, validator) == []
        assert load(tmp_path, text).shock.peak_force == 30.0


def test_a_profile_that_cannot_be_imported_may_have_any_parameters(tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    validator = _plug(tmp_path, patch, pulses="raise RuntimeError('out of order')")
    assert schema_faults(_pulse("declared", "delay: x, more: 1", ", duration_ratio: 2"), validator) == []
    assert "out of order" in _parameters_of(validator, "declared")["description"]
