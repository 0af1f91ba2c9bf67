"""Tests of contact laws against each clause of their contract."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import declaration_of
from shockwave.registry.plugin_check import is_value
from shockwave.registry.registry import entry_of
from shockwave.scenario.scenario import Scenario
from shockwave.scene.chain import Chain
from shockwave.scene.chain_end import Wall
from shockwave.scene.contact_law import ContactLaw
from shockwave.scene.damping import Dashpot
from shockwave.scene.material import Material
from shockwave.simulation.simulate import simulate
from shockwave.testing.contact_samples import SCENES, Sample, scene_of
from shockwave.testing.contract import Contract, check_parameters, check_twin

# Overlaps, over the greatest one of Hertz's law, and closing velocities, over the greatest one.
_OVERLAPS = np.arange(-2, 31) / 10
_VELOCITIES = np.arange(-4, 5) / 4
# Where the force is searched for jumps: overlaps, closing velocities, and lengths of the intervals that begin there.
_LINES = {
    "overlap": (np.arange(-20, 300) / 100, _VELOCITIES[::2], 0.01, 0.0),
    "closing velocity": (_OVERLAPS[::3], np.arange(-50, 50) / 50, 0.0, 0.02),
}
# Greatest overlaps over that of Hertz's law, and velocities over the greatest one, of contacts that close and open
# again; their turning points over the greatest overlap, in turn; and points of each way between two of them.
_SIZES = np.geomspace(1e-3, 3.0, 50)
_SPEEDS = np.array([0.0, 0.1, 1.0])
_CYCLES = (0, 1, 0), (0, 1, 0), (0, 0.5, 0), (0, 1, 0.5, 1, 0.5, 1, 0)
_POINTS = 200
# Halvings of an interval, after which a continuous force changes by less than this share of the greatest force.
_HALVINGS = 100
_JUMP = 1e-5
# Rounding errors of a few operations, over the greatest value.
_ROUNDING = 1e-12
# Change of a force by an update, over the greatest force: the state may be the result of an iteration.
_UPDATED = 1e-9
# Relative tolerances of the simulations, and the end of the simulated time in durations of a collision.
_TOLERANCES = (1e-6, 1e-8)
_UNTIL = 3.0
# Change of a greatest force over the sum of its estimated errors, which are not strict bounds; and time over the end of
# the simulated time beyond which a force is still rising.
_SLACK = 3.0
_RISING = 0.999
# Errors of the balances of momentum and energy, over what the excitation applies: rounding of the sums over some
# thousand steps; and ten times the larger tolerance, also the error of the work along a curve with kinks.
_MOMENTUM = 1e-12
_ENERGY = 1e-5
_REGISTER = "return an Entry with its address from shockwave_contacts in your hooks, and install the distribution"


class ContactLawContract(Contract):
    """Tests of contact laws against the contract of `shockwave.ContactLaw`; a subclass lists them.

    ::

        from shockwave.testing import ContactLawContract
        from my_contacts.coated import Coated

        class TestCoated(ContactLawContract):
            laws = [Coated(thickness=1e-6)]

    Attributes
    ----------
    laws : list of ContactLaw
        Objects, not classes; include parameters at the ends of their ranges.
    chain : Chain
        Material and mean radius of the granules of the tests; by default steel beads.
    velocity : float
        Velocity of the strikers, and greatest closing velocity [m/s]. Choose it so that all parts of the law act.
    leave_out : dict of str
        Omitted clauses, with the reasons: ``{"clause 3": "the force jumps where a liquid film breaks"}``. They are
        shown as skipped. Tests that are not clauses are given by name.
    """

    laws: ClassVar[Sequence[ContactLaw]]
    chain: ClassVar[Chain] = Chain(
        material=Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=5e-3
    )
    velocity: ClassVar[float] = 1.0

    _member = "law"
    _type = ContactLaw
    _wanted = "objects (not classes) of subclasses of ContactLaw"

    def _sample(self, law: ContactLaw, overlaps: Any = _OVERLAPS, velocities: Any = _VELOCITIES) -> Sample:
        _, chain, _ = scene_of(self.chain, law, self.velocity, "5-fixed-striker")
        return Sample.of(chain, self.velocity, overlaps, velocities)

    @pytest.mark.parametrize("method", ["force", "update"])
    def test_clause_1_contacts_are_independent(self, law: ContactLaw, method: str) -> None:
        sample, name = self._sample(law), {"force": "forces", "update": "updates"}[method]
        values = getattr(sample, name)()
        allowed = _ROUNDING * np.abs(values).max(initial=0.0)
        for places in (slice(None, None, -1), slice(4, None, 601), slice(-1, None)):
            part = getattr(sample.take(places), name)()
            same = np.allclose(part, values[..., places], rtol=0, atol=allowed)
            message = f"{method} returns other values for the same contact beside other contacts, or in another order"
            assert same, f"{message}: use its own overlap, velocity, state and properties only"

    def test_clause_2_open_contacts_have_no_force(self, law: ContactLaw) -> None:
        sample = self._sample(law, [-1.0, -1e-9, 0.0])
        forces = np.asarray(law.force(*sample.arguments))
        sample.check(forces <= 0, forces, "the force is {} {}: use overlap.clip(0) in all terms")

    @pytest.mark.parametrize("along", _LINES)
    def test_clause_3_the_force_is_continuous(self, law: ContactLaw, along: str) -> None:
        overlaps, velocities, further, faster = _LINES[along]
        sample = self._sample(law, overlaps, velocities)
        ends = self._sample(law, overlaps + further, velocities + faster)
        more, increase = ends.overlap - sample.overlap, ends.velocity - sample.velocity
        share, size = np.zeros(more.shape), 1.0
        below, above = sample.forces(), sample.forces(more, increase)
        allowed = _JUMP * above.max()
        for _ in range(_HALVINGS):
            size /= 2
            middle = sample.forces((share + size) * more, (share + size) * increase)
            upper = np.abs(above - middle) > np.abs(middle - below)
            share += upper * size
            below, above = np.where(upper, middle, below), np.where(upper, above, middle)
        jumps = np.abs(above - below)
        at = attrs.evolve(sample, overlap=sample.overlap + share * more, velocity=sample.velocity + share * increase)
        remedy = "multiply terms with the velocity by a power of the overlap, and join branches where they are equal"
        at.check(jumps <= allowed, jumps, f"along the {along} the force jumps by {{}} {{}}: {remedy}")

    @pytest.mark.parametrize("clause", ["clause 3, force", "clause 5, update"])
    def test_it_has_no_side_effects(self, law: ContactLaw, clause: str) -> None:
        name, sample = clause.partition(", ")[2], self._sample(law)
        method = getattr(law, name)
        before, other = sample.take(slice(None)), sample.take(slice(None, None, -1))
        first = np.array(method(*sample.arguments))
        assert sample.equals(before), f"{name} must not change its arguments: return a new array"
        method(*other.arguments)
        again = method(*sample.arguments)
        assert np.array_equal(first, again), f"{name} depends on earlier calls: store nothing but the state"

    def test_clause_4_the_force_acts_beyond_the_history(self, law: ContactLaw) -> None:
        states = type(law).states
        assert type(states) is int, f"states must be a whole number, the values of a contact's history (got {states!r})"
        assert states >= 0, f"states must be >= 0 (got {states})"
        sample = self._sample(law, _OVERLAPS[_OVERLAPS >= 1], _VELOCITIES[_VELOCITIES >= 0])
        forces = sample.forces()
        remedy = "the force must also act beyond the history, and where the state is zero"
        sample.check(forces > 0, forces, f"the force is {{}} {{}}, greater than any before: {remedy}")

    def test_clause_5_update_returns_a_new_array(self, law: ContactLaw) -> None:
        sample = self._sample(law)
        sample.updates()
        state = law.update(*sample.arguments)
        shared = any(np.shares_memory(state, each) for each in sample.arguments[:2])
        assert not shared, "update returns overlap or closing_velocity itself: return a copy"

    def test_clause_5_an_update_keeps_the_force(self, law: ContactLaw) -> None:
        sample = self._sample(law)
        forces, state = sample.forces(), sample.updates()
        changes = np.abs(attrs.evolve(sample, state=state).forces() - forces)
        remedy = "let the new state give the same force here, or energy is added or removed"
        sample.check(changes <= _UPDATED * forces.max(), changes, f"update changes the force by {{}} {{}}: {remedy}")

    def test_clause_6_no_energy_is_created(self, law: ContactLaw) -> None:
        _, chain, _ = scene_of(self.chain, law, self.velocity, "5-fixed-striker")
        contacts = Sample.of(chain, self.velocity, _SIZES, _SPEEDS, path=())
        for turns in _CYCLES:
            after, received, loading = contacts.work(turns, _POINTS)
            gained = -100 * received / np.maximum(loading, 1e-300)
            message = "a contact that closes up to this overlap and opens again returns {} more energy than it received"
            remedy = (
                "keep the unloading curve below the loading curve; velocity-dependent terms must only dissipate energy"
            )
            contacts.check(gained <= 100 * _ENERGY, gained, f"{message}, {{}}: {remedy}", unit="%")
            contacts = after

    def test_fields_are_parameters_with_unit_and_meaning(self, law: ContactLaw) -> None:
        check_parameters(law)
        for field in _fields(law):
            number = type(getattr(law, field.name)) in (int, float)
            remedy = f"declare it by  {field.name}: float = shockwave.quantity('m', 'description')"
            assert declaration_of(field) or not number, f"the number {field.name} has no unit: {remedy}"

    def test_it_is_a_value(self, law: ContactLaw) -> None:
        assert is_value(law), "a law must be equal to another one with the same parameters: use @attrs.frozen"
        with pytest.raises(AttributeError):
            law.states = 0
        for twin in (copy.deepcopy(law), pickle.loads(pickle.dumps(law))):
            check_twin(law, twin)

    def test_it_is_registered_and_loads_from_a_scenario(self, law: ContactLaw) -> None:
        entry = entry_of("contacts", type(law))
        assert entry, f"no contact is registered for {type(law).__name__}: {_REGISTER}"
        contact: dict[str, Any] = {"model": entry.name}
        for field in _fields(law):
            spec, value = declaration_of(field), getattr(law, field.name)
            contact[field.name] = f"{value!r} {spec.unit}" if spec and spec.unit else value
        chain = {"material": "paper-steel", "diameter": "9.5 mm", "granules": 2, "contact": contact}
        loaded = Scenario.from_yaml(json.dumps({"chain": chain, "impact": {"velocity": "1 m/s"}})).chain.contact
        assert loaded == law, f"a scenario with contact: {json.dumps(contact)} has another law, {loaded!r}"

    @pytest.mark.parametrize("name", ["damping", "precompression", "gravity"])
    def test_it_excludes_damping_and_static_loads(self, law: ContactLaw, name: str) -> None:
        value: Any = {"damping": Dashpot(coefficient=1.0), "precompression": 10.0, "gravity": 9.81}[name]
        with pytest.raises(InvalidValueError, match=f"{name}: must be left out"):
            attrs.evolve(self.chain, granules=2, end=Wall(), contact=law, **{name: value})

    @pytest.mark.parametrize("name", SCENES)
    def test_it_is_simulated(self, law: ContactLaw, name: str) -> None:
        excitation, chain, duration = scene_of(self.chain, law, self.velocity, name)
        until = _UNTIL * duration
        results = [simulate(excitation, chain, rtol=rtol, until=until) for rtol in _TOLERANCES]
        for result in results:
            defect = result.momentum_defect
            assert defect <= _MOMENTUM, f"the momentum is violated by {defect:.1e} of what is applied"
            assert result.energy_defect <= _ENERGY, f"the energy balance is violated by {result.energy_defect:.1e}"
        for loose, tight in zip(*(result.contacts for result in results), strict=True):
            first, second = loose.peak_force, tight.peak_force
            error = max(_TOLERANCES[0], loose.error_estimate + tight.error_estimate) * second
            change, rising = abs(first - second), tight.time > _RISING * results[-1].end
            forces = f"{first:.9g} N at rtol {_TOLERANCES[0]:g} and {second:.9g} N at {_TOLERANCES[1]:g}"
            seen = (
                f"in the scene {name} (granules, end, load) the greatest force at contact {loose.contact} is {forces}"
            )
            allowed = f"it changes by {change:.6g} N, more than {_SLACK:g} times the estimated error of {error:.6g} N"
            remedy = "a possible cause is a state that depends on the step size"
            assert rising or change <= _SLACK * error, f"clause 4: {seen}: {allowed}; {remedy}"

    def test_its_results_are_documents(self, law: ContactLaw) -> None:
        excitation, chain, duration = scene_of(self.chain, law, self.velocity, "5-movable-shock")
        result = simulate(excitation, chain, rtol=1e-3, until=_UNTIL * duration)
        json.dumps(result.to_dict(), allow_nan=False)


def _fields(law: ContactLaw) -> Iterable[attrs.Attribute[Any]]:
    fields: Iterable[attrs.Attribute[Any]] = type(law).__attrs_attrs__  # type: ignore[attr-defined]
    return fields
