"""Tests of profiles against each clause of their contract."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar

import numpy as np
import pytest

from shockwave.base.numerics import FloatArray
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.contract_check import CLAUSES, check_closed_integrals
from shockwave.profiles.quadrature import Integrand
from shockwave.profiles.quadrature.gauss_legendre import GaussLegendre
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.plugin_check import ViolationError
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.material import Material
from shockwave.scene.shock import Shock
from shockwave.simulation.simulate import simulate
from shockwave.testing.contract import Contract, check_parameters, check_twin

# Clauses on which no other one relies.
_ALONE = ("clause 5", "clause 6", "clause 7")
# Largest relative error of a closed form, near the accuracy of a quadrature.
_CLOSED = 1e-11
# Fractions of rise and decay at which running integrals are compared.
_SHARES = (1e-6, 1e-3, 0.1, 0.45, 0.8, 0.999, 1.0)
# Largest width of panels next to a jump or a kink, in units of rise or decay.
_ROUGH = 1e-5
# First division of the intervals, as a fraction.
_CUT = 0.4563
# The scene of the tests: steel beads, peak force [N] and duration in characteristic times.
_CHAIN = Chain(material=Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
_FORCE = 100.0
_DURATION = 3.0


class ProfileContract(Contract):
    """Tests of profiles against the contract of `shockwave.ShockProfile`; a subclass lists them.

    ::

        from shockwave.testing import ProfileContract
        from my_pulses.trapezoid import Trapezoid

        class TestTrapezoid(ProfileContract):
            profiles = [Trapezoid(plateau=2, duration_ratio=5)]

    If a clause is violated, tests of clauses that depend on it are skipped, so that one error fails one test.

    Attributes
    ----------
    profiles : list of ShockProfile
        Objects, not classes; include parameters at the ends of their ranges.
    leave_out : dict of str
        Omitted clauses, with the reasons: ``{"clause 5": "the closed form is accurate to 1e-9"}``. They are shown as
        skipped. Tests that are not clauses are given by name.
    """

    profiles: ClassVar[Sequence[ShockProfile]]

    _member = "profile"
    _type = ShockProfile
    _wanted = "objects (not classes) of subclasses of ShockProfile"

    def _check(self, profile: ShockProfile, clause: str = "") -> None:
        """Fail if the profile violates the clause; skip if it violates one on which the clause relies, or any if ""."""
        for name, check in CLAUSES.items():
            alone = name.startswith(_ALONE) and clause not in (name, "")
            if alone or name.partition(",")[0] in self.leave_out:
                continue
            try:
                check(profile)
            except ViolationError as error:
                if name != clause:
                    pytest.skip(f"see {name} first")
                pytest.fail(f"{profile!r}: {error}", pytrace=False)
            if name == clause:
                return

    @pytest.mark.parametrize("clause", CLAUSES)
    def test_it_holds(self, profile: ShockProfile, clause: str) -> None:
        self._check(profile, clause)

    def test_clause_1_fields_are_parameters_with_unit_and_meaning(self, profile: ShockProfile) -> None:
        check_parameters(profile)

    def test_clause_4_every_jump_and_kink_is_a_breakpoint(self, profile: ShockProfile) -> None:
        self._check(profile, "clause 4, kinks")
        at = rough_place(profile.force, profile.breakpoints)
        assert at is None, f"the force has a jump or a kink at s = {at:.6g}, which is not a breakpoint"

    def test_clause_5_closed_forms_agree_with_quadrature(self, profile: ShockProfile) -> None:
        self._check(profile)
        check_closed_integrals(profile, _CLOSED, _SHARES)

    def test_it_is_a_value(self, profile: ShockProfile) -> None:
        if type(profile).__eq__ is not object.__eq__:
            check_twin(profile, copy.deepcopy(profile))

    def test_it_is_predicted(self, profile: ShockProfile) -> None:
        self._check(profile)
        assert 0 < Predictor(model="section-4").predict(_shock(profile), _CHAIN).peak_force < math.inf

    def test_it_is_simulated(self, profile: ShockProfile) -> None:
        self._check(profile)
        error = simulate(_shock(profile), _CHAIN, rtol=1e-3, waves="primary").error_estimate
        assert error <= 1e-3, f"the error of the peak force is {error:.1e}: probably a breakpoint is missing"


def rough_place(force: Integrand, breakpoints: Sequence[float]) -> float | None:
    """Time of a jump or kink other than a breakpoint, where a quadrature needs a very narrow panel."""
    panels: list[tuple[float, float]] = []

    def watch(s: FloatArray) -> FloatArray:
        panels.append((s.min(), s.max()))
        return force(s)

    # An uneven division, so that a kink at a simple fraction does not fall between two panels.
    between = [a + _CUT * (b - a) for a, b in pairwise(breakpoints)]
    GaussLegendre().integrate(watch, sorted([*breakpoints, *between]))
    begin, end = np.transpose(panels)
    middle, width = (begin + end) / 2, end - begin
    nearest = np.min([np.abs(middle - point) for point in breakpoints], axis=0)
    part = np.where(end <= 1, 1.0, breakpoints[-1] - 1)
    narrow = (width < _ROUGH * part) & (width < nearest / 10)
    return float(middle[narrow][width[narrow].argmin()]) if narrow.any() else None


def _shock(profile: ShockProfile) -> Shock:
    rise_time = _DURATION * Scales.of(_CHAIN, _FORCE).time / float(profile.duration_ratio)
    return Shock(profile=profile, peak_force=_FORCE, rise_time=rise_time)
