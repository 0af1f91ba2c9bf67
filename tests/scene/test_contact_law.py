"""Every contact law, built in or of a plugin, in chains with every end, under shocks and strikers."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from conftest import Install
from shockwave.engine.nystroem_tableaux import scaled_error
from shockwave.scene.contact_law import BoundLaw, Pairs
from shockwave.scene.layout import Layout
from support.command_line import scenario, shockwave
from support.pages import DOCS, blocks_of, execute
from support.scenes import CHAIN, FORCE, UNITS, triangle

MASS = CHAIN.granule_mass
#: Coefficient of a dashpot that damps a contact weakly within a characteristic time [N s/m].
DASHPOT = 0.2 * MASS / UNITS.time
VISCOUS_TIME = 0.1 * UNITS.time
EXCITATIONS: dict[str, sw.Shock | sw.Impact] = {"shock": triangle(2.0), "striker": sw.Impact(velocity=UNITS.velocity)}
ENDS = {
    "free": None,
    "fixed": sw.Wall(),
    "movable": sw.Wall(mass=2 * MASS, stiffness=MASS / UNITS.time**2, damping=DASHPOT),
}


@attrs.frozen
class Hertz(sw.ContactLaw):
    """The built-in force, as a plugin states it."""

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return pairs.stiffnesses * overlap.clip(0) ** 1.5


@attrs.frozen
class Viscoelastic(sw.ContactLaw):
    """Kuwabara and Kono's force, as a plugin states it."""

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        root = np.sqrt(overlap.clip(0))
        return pairs.stiffnesses * root * (overlap + 1.5 * VISCOUS_TIME * closing_velocity)


@attrs.frozen
class Greatest(Hertz):
    """Hertz's force with a state that does not change it."""

    states = 2

    def update(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return np.maximum(state, (overlap, closing_velocity))


@attrs.frozen
class Coated(Hertz):
    """Hertz's force, of which a tenth acts up to an overlap of 1 um: it has a kink there."""

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        raised = overlap.clip(0) ** 1.5
        return pairs.stiffnesses * (0.1 * np.minimum(raised, 1e-9) + (raised - 1e-9).clip(0))


@attrs.frozen
class Creating(Hertz):
    """Hertz's force in loading, and a tenth more in unloading."""

    states = 1

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        greatest = np.maximum(overlap, state[0]).clip(1e-300)
        return Hertz.force(self, overlap, closing_velocity, state, pairs) * (1.1 - 0.1 * overlap / greatest)

    def update(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return np.maximum(state, overlap)


def of_the_docs() -> sw.ContactLaw:
    """The example of the page on plugins."""
    names: dict[str, Any] = {"__name__": __name__}
    (block,) = (each for each in blocks_of(DOCS / "plugins.md") if "class Viscous(sw.ContactLaw)" in each.text)
    execute(block, names)
    law: sw.ContactLaw = names["Viscous"](time=VISCOUS_TIME)
    return law


LAWS: dict[str, dict[str, Any]] = {
    "hertz": {},
    "power-law": {"contact": sw.PowerContact(exponent=2.5, stiffness=CHAIN.contact_stiffness * 1e3)},
    "kuwabara-kono": {"damping": sw.KuwabaraKono(time=VISCOUS_TIME)},
    "dashpot": {"damping": sw.Dashpot(coefficient=DASHPOT)},
    "tsuji": {"damping": sw.Tsuji(restitution=0.8)},
    "docs": {"contact": of_the_docs()},
}


def chain(granules: int, end: str, **laws: Any) -> sw.Chain:
    return attrs.evolve(CHAIN, granules=[sw.Segment(count=granules)], end=ENDS[end], **laws)


#: Law, granules, end and excitation; the NumPy code, which runs the laws of plugins, is slow, and needs no long chain.
BALANCED = [
    (law, granules, end, excitation)
    for law, granules, end, excitation in product(LAWS, (1, 5, 40), ENDS, EXCITATIONS)
    if (granules, end, excitation) != (1, "free", "shock")  # no contact
    and (law != "docs" or granules == 1 or (granules, end) == (5, "movable"))
]


@pytest.mark.parametrize(("law", "granules", "end", "excitation"), BALANCED)
def test_momentum_and_energy_are_balanced(law: str, granules: int, end: str, excitation: str) -> None:
    until = 10 * UNITS.time if law == "docs" or granules == 40 else None
    laws = LAWS[law] or {"damping": sw.Dashpot(coefficient=0.0)}
    result: Any = sw.simulate(EXCITATIONS[excitation], chain(granules, end, **laws), rtol=1e-3, until=until)
    if law != "docs":  # first pulses of every contact take many runs
        json.dumps(result.to_dict(), allow_nan=False)
    assert not any("tolerance" in warning for warning in result.warnings)
    assert result.greatest_force.peak_force > 0.1 * FORCE
    # rounding errors of sums over a thousand steps
    assert result.momentum_defect < 1e-13
    # a step is accurate to a hundredth of rtol, and some hundred steps add up to a tenth of it at most
    assert result.energy_defect < 1e-4


def test_a_result_of_a_plugin_is_a_document() -> None:
    result: Any = sw.simulate(EXCITATIONS["striker"], chain(1, "free", contact=Hertz()), rtol=1e-3)
    json.dumps(result.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("law", "granules", "until"),
    [(Greatest(), 5, None), (Hertz(), 20, 30.0)],
    ids=["stateful-5", "stateless-20"],
)
def test_hertz_as_a_plugin_is_the_built_in_law(law: sw.ContactLaw, granules: int, until: float | None) -> None:
    options: dict[str, Any] = {"rtol": 1e-8, "until": until and until * UNITS.time}
    built_in = forces(chain(granules, "fixed", damping=sw.Dashpot(coefficient=0.0)), **options)
    # both are a hundred times as accurate as rtol, until late collisions amplify the errors
    plugin = forces(chain(granules, "fixed", contact=law), **options)
    assert plugin == pytest.approx(built_in, rel=2e-9, abs=1e-9 * FORCE)


@pytest.mark.parametrize("granules", [1, 5])
def test_a_law_that_creates_energy_is_reported(granules: int) -> None:
    result: Any = sw.simulate(EXCITATIONS["striker"], chain(granules, "free", contact=Creating()), rtol=1e-4)
    (warning,) = (each for each in result.warnings if "creates energy" in each)
    assert warning.startswith("The contact law Creating creates energy: contact 0 has returned")
    assert result.dissipated.energy < 0


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-6])
@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_an_elastic_law_is_not_reported(excitation: str, rtol: float) -> None:
    result: Any = sw.simulate(EXCITATIONS[excitation], chain(5, "movable", contact=Hertz()), rtol=rtol)
    assert not any("creates energy" in warning for warning in result.warnings)


@pytest.mark.parametrize(
    ("profile", "rise_time"),
    [(sw.HalfSine(), 1e-4), (sw.Triangular(duration_ratio=2), 1e-3)],
    ids=["half-sine", "slow"],
)
def test_an_elastic_law_that_returns_the_work_of_a_slow_shock_is_not_reported(profile: Any, rise_time: float) -> None:
    steel = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    bead = sw.Chain(material=steel, radius=5e-3, granules=1, end=sw.Wall(), contact=Coated())
    slow = sw.Shock(profile=profile, peak_force=100.0, rise_time=rise_time)
    result: Any = sw.simulate(slow, bead, rtol=1e-6)
    assert not any("creates energy" in warning for warning in result.warnings)


def test_greatest_force_of_a_viscous_plugin_is_before_the_greatest_overlap() -> None:
    laws: list[dict[str, Any]] = [{"contact": Viscoelastic()}, {"damping": sw.KuwabaraKono(time=VISCOUS_TIME)}]
    plugin, built_in = (forces(chain(5, "movable", **law), rtol=1e-8) for law in laws)
    # at the greatest overlap the force is a percent below its maximum
    assert plugin == pytest.approx(built_in, rel=1e-9)


def forces(scene: sw.Chain, **options: Any) -> list[float]:
    """Greatest force at every contact."""
    contacts = range(0 if scene.count is None else scene.count)  # of a chain with a wall
    result: Any = sw.simulate(EXCITATIONS["shock"], scene, contacts=contacts, **options)
    return [peak.peak_force for peak in result.contacts]


def test_compiled_code_is_refused_for_a_law_that_it_does_not_have() -> None:
    with pytest.raises(sw.InvalidValueError, match="backend: must be auto or numpy for the contact law Hertz"):
        forces(chain(3, "fixed", contact=Hertz()), backend="compiled")


@pytest.mark.parametrize("end", ENDS)
def test_histories_and_gaps_of_a_chain_with_a_plugin(end: str) -> None:
    apart = attrs.evolve(chain(5, end), granules=[sw.Segment(count=5, gap=1e-6)], contact=Greatest())
    options: dict[str, Any] = {"rtol": 1e-3, "until": 15 * UNITS.time, "record": ("forces", "field", "energies")}
    result: Any = sw.simulate(EXCITATIONS["striker"], apart, **options)
    greatest = result.greatest_force.peak_force
    assert result.recording.forces.max() == pytest.approx(greatest, rel=0.05)  # time between samples
    assert np.isfinite(result.recording.kinetic_energy).all()
    assert result.momentum_defect < 1e-13


# A few products, quotients and roots: each rounds once.
ROUNDINGS = 1e-14


@attrs.frozen
class Worn(sw.ContactLaw):
    """A law that softens with the greatest overlap."""

    states = 1

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return pairs.stiffnesses * overlap * (1 - state[0]) - 0.5 * closing_velocity

    def update(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return np.maximum(state, overlap)


def test_a_law_is_evaluated_in_scaled_units() -> None:
    layout = Layout.of(chain(4, "free", contact=Worn()), EXCITATIONS["shock"])
    assert layout.law == Worn()
    law = BoundLaw(layout.law, layout.pairs, length=1.0, velocity=1.0, unit_force=1.0)
    assert law.initial_state().shape == (1, 3)
    overlap, velocity, state = np.array([1e-6, -1e-6, 1e-6]), np.array([0.1, 0.0, 1e6]), np.array([[0.5, 0.0, 0.0]])
    forces = law.force(overlap, velocity, state)
    # neither an open contact nor an attraction has a force
    assert forces.tolist() == [pytest.approx(0.5e-6 * CHAIN.contact_stiffness - 0.05, rel=ROUNDINGS), 0.0, 0.0]
    scaled = attrs.evolve(law, length=1e-6, velocity=0.1, unit_force=2.0)
    assert scaled.force(overlap / 1e-6, velocity / 0.1, state) == pytest.approx(forces / 2, rel=ROUNDINGS)
    assert scaled.update(overlap / 1e-6, velocity / 0.1, np.zeros((1, 3))) == pytest.approx(
        np.array([[1e-6, 0, 1e-6]]), rel=ROUNDINGS
    )


def test_error_of_a_step_too_short_to_have_one_is_a_number() -> None:
    # their squares underflow
    assert scaled_error(1e-170, 1e-170) == 1e-170


# ---------------------------------------------------------------- faults of plugins

HOOKS = """
from shockwave.hooks import Entry, hookimpl

@hookimpl
def shockwave_contacts():
    return [Entry("{name}", "{module}_pulse:Law", "a law")]
"""
#: Hertz's law, which does something else from a certain overlap on.
LAW = """
import numpy as np
from attrs import frozen
import shockwave as sw

@frozen
class Law(sw.ContactLaw):
    onset: float = sw.quantity("m", "overlap", above=0)

    states = 1

    def force(self, overlap, closing_velocity, state, pairs):
        if overlap.max() > self.onset:
            {force}
        return pairs.stiffnesses * overlap.clip(0) ** 1.5

    def update(self, overlap, closing_velocity, state, pairs):
        if overlap.max() > self.onset:
            {update}
        return state
"""
RAISE = "raise RuntimeError('out of order')"
#: Method, what it does, and what is reported of it.
FAULTS = {
    "force raises": ("force", RAISE, "RuntimeError: out of order"),
    "update raises": ("update", RAISE, "RuntimeError: out of order"),
    "force is not finite": ("force", "return overlap * np.nan", "force must return finite numbers"),
    "force has another shape": ("force", "return np.zeros(7)", "numbers of shape (2,) (got shape (7,))"),
    "update returns nothing": ("update", "return None", "update must return finite numbers of shape (1, 2) (got"),
}


def install_law(install: Install, fault: str = "force raises") -> None:
    method, code, _ = FAULTS[fault]
    install(
        "faulty-laws",
        hooks=HOOKS,
        pulse=LAW.format(**{"force": "pass", "update": "pass", method: code}),
        name="test-law",
    )


def written(folder: Path, parameters: str, name: str = "scene") -> Path:
    """A scenario of a chain with the law of the plugin."""
    chain = "chain: {material: paper-steel, diameter: 9.5 mm, granules: 2, end: {wall: same},"
    shock = "shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}"
    contact, simulate = f" contact: {{model: test-law, {parameters}}}}}", "simulate: {until: 50 us, rtol: 1e-3}"
    return scenario(folder, chain, contact, shock, simulate, name=name)


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_a_law_ends_with_4_and_names_its_plugin(
    fault: str, command: str, install: Install, tmp_path: Path
) -> None:
    install_law(install, fault)
    file = written(tmp_path, "onset: 1 um")
    answer = shockwave(command, file)
    assert (answer.status, answer.out) == (4, "")
    (line,) = answer.err.splitlines()  # no traceback
    assert line.startswith(f"{file}: contact 'test-law' of faulty-laws: ")
    assert FAULTS[fault][2] in line


@pytest.mark.parametrize("fault", ["force raises", "update returns nothing"])
def test_a_fault_of_a_law_spoils_no_other_scene(fault: str, install: Install, tmp_path: Path) -> None:
    install_law(install, fault)
    sound, faulty = (
        sw.load_scenario(written(tmp_path, f"onset: {onset}", name))
        for onset, name in (("1 m", "sound"), ("1 um", "faulty"))
    )
    chains = [sound.chain, faulty.chain, sound.chain]
    before, error, after = sw.simulate_many([sound.shock] * 3, chains, until=50e-6, rtol=1e-3)
    assert isinstance(error, sw.PluginError)
    assert "'test-law' of faulty-laws" in str(error)
    alone = sw.simulate(sound)
    assert before.greatest_force == after.greatest_force == alone.greatest_force
    outcomes = sw.Predictor().predict_many([sound.shock] * 3, chains, sound.simulate)
    assert [outcomes[index].greatest_force for index in (0, 2)] == [alone.greatest_force] * 2
    with pytest.raises(sw.PluginError, match="'test-law' of faulty-laws"):
        _ = outcomes[1].greatest_force


@pytest.mark.parametrize(
    ("parameters", "column", "problem"),
    [
        ("onset: 1 um, onst: 1", 42, "chain.contact.onst: unknown key (got 'onst'; did you mean 'onset'?"),
        ("onset: -1 um", 36, "chain.contact.onset: must be > 0"),
    ],
    ids=["unknown", "out of range"],
)
def test_a_wrong_parameter_of_a_law_is_an_error_of_the_scenario_in_its_place(
    parameters: str, column: int, problem: str, install: Install, tmp_path: Path
) -> None:
    install_law(install)
    file = written(tmp_path, parameters)
    answer = shockwave("predict", file)
    assert answer.status == 3
    assert answer.err.startswith(f"{file}:2:{column}: {problem}")
