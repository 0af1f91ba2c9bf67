"""The schema and the templates of what a plugin brings: its parameters work like shockwave's own."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

from shockwave.base.errors import PluginError, ScenarioError
from shockwave.scenario.loader import scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.schema import schema
from shockwave.scenario.template import template
from shockwave.scenario.yaml_document import parse_document
from support.distributions import install
from support.pages import workplace
from support.texts import CHAIN

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
from shockwave.base.quantity_fields import Quantity
from shockwave.profiles.triangular import Triangular

KNOTS = Quantity("s", "knots", above=0, samples=True, optional=True)

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
    made = schema()
    Draft7Validator.check_schema(made)
    return Draft7Validator(made)


def _faults(text: str, validator: Draft7Validator) -> list[str]:
    """Where the schema finds a scenario wrong, read as the loader reads it."""
    data = parse_document(text, "scenario.yaml").data
    return [str(fault.json_path) for fault in validator.iter_errors(data)]


def _load(folder: Path, text: str) -> Scenario:
    return scenario_of(parse_document(text, "x"), folder / "x")


def _pulse(profile: str, parameters: str, more: str = "") -> str:
    head = f"shock: {{profile: {profile}, peak_force: 1 N, rise_time: 1 s{more}"
    return f"{CHAIN}{head}, parameters: {{{parameters}}}}}\n"


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


@pytest.mark.usefixtures("validator")
class TestPlugin:
    @pytest.mark.parametrize(
        ("profile", "parameters", "more"),
        [
            ("declared", "delay: 2 ms, step: null, knots: [1, 2 s]", ""),
            ("declared", "delay: 0.002, step: -3", ", duration_ratio: 25"),
            ("undeclared", "count: '3', kind: even, weights: [1, 50 %], flag: null, limit: 2", ", duration_ratio: 2"),
            ("undeclared", "count: 3, shape: anything, flag: true", ", duration_ratio: 2"),
            ("plain", "power: 2", ""),
        ],
    )
    def test_its_parameters_are_admitted(
        self, tmp_path: Path, validator: Draft7Validator, profile: str, parameters: str, more: str
    ) -> None:
        text = _pulse(profile, parameters, more)
        assert _faults(text, validator) == []
        assert _load(tmp_path, text).shock.peak_force == 1.0

    @pytest.mark.parametrize(
        "case",
        [
            ("declared", "", "", "parameters", False),
            ("declared", "delay: 0.001", "", "parameters.delay", True),
            ("declared", "delay: 2 ms, knots: [1, -2 s]", "", "parameters.knots[1]", False),
            ("declared", "delay: 2 ms, dealy: 2", "", "parameters", True),
            ("declared", "delay: 2 ms, step: 11", "", "parameters.step", False),
            ("declared", "delay: 2 ms", ", duration_ratio: 20", "duration_ratio", True),
            ("undeclared", "count: 1.5", ", duration_ratio: 2", "parameters.count", True),
            ("undeclared", "count: 1, kind: none", ", duration_ratio: 2", "parameters.kind", True),
            ("undeclared", "count: 1, weights: [1, x]", ", duration_ratio: 2", "parameters.weights[1]", True),
            ("plain", "power: strong", "", "parameters.power", True),
            ("plain", "", ", duration_ratio: 3", "duration_ratio", True),
        ],
    )
    def test_its_bad_parameters_are_rejected_in_their_place(
        self, tmp_path: Path, validator: Draft7Validator, case: tuple[str, str, str, str, bool]
    ) -> None:
        profile, parameters, more, place, seen = case
        text = _pulse(profile, parameters, more)
        assert _faults(text, validator) == ([f"$.shock.{place}"] if seen else [])
        with pytest.raises(ScenarioError) as caught:
            _load(tmp_path, text)
        assert caught.value.faults[0].path.startswith(f"shock.{place}")

    def test_units_and_kinds_are_converted(self, tmp_path: Path) -> None:
        profile: Any = _load(tmp_path, _pulse("declared", "delay: 2 ms, knots: [1, 20 ms]")).shock.profile
        assert (profile.delay, profile.knots, profile.duration_ratio) == (2e-3, (1.0, 0.02), 30.0)
        text = "count: '3', kind: even, weights: [1, 50 %]"
        profile = _load(tmp_path, _pulse("undeclared", text, ", duration_ratio: 2")).shock.profile
        assert (profile.count, profile.kind, profile.weights) == (3, "even", (1.0, 0.5))

    def test_other_errors_of_the_constructor_are_errors_of_the_plugin(self, tmp_path: Path) -> None:
        with pytest.raises(PluginError, match=r"profile 'plain' of fake-pulses: .*ZeroDivisionError"):
            _load(tmp_path, _pulse("plain", "power: 0"))

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
            ("plain", "  # duration: 150 us  # total duration n t0, instead of t0 or n, > 0 s"),
        ],
    )
    def test_templates_hold_its_parameters_and_load(
        self, tmp_path: Path, validator: Draft7Validator, profile: str, line: str
    ) -> None:
        text = template(profile)
        assert line in text.splitlines()
        assert _faults(text, validator) == []
        assert _load(tmp_path, text).shock.peak_force == 100.0


def test_a_profile_that_cannot_be_imported_may_have_any_parameters(tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    validator = _plug(tmp_path, patch, pulses="raise RuntimeError('out of order')")
    assert _faults(_pulse("declared", "delay: x, more: 1", ", duration_ratio: 2"), validator) == []
    assert "out of order" in _parameters_of(validator, "declared")["description"]
