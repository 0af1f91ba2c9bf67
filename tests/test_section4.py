"""Section 4 as a decision: the paper's two tables, and one case for each branch."""

from __future__ import annotations

import pytest

import shockwave as sw
from scenes import CHAIN, FORCE
from shockwave.prediction.model_interface import ScaledShock, Settings
from shockwave.prediction.section4 import predict

PAPER = sw.Predictor(momentum_coefficient="paper")
#: A F0^(-1/6) of the paper's beads at 100 N with 13/3, from eq. (4c) written out.
TIME = 13 / 3 * ((1 - 0.3**2) * 7958**1.5 * 4.75e-3**4 / 193e9) ** (1 / 3) * FORCE ** (-1 / 6)


def _power(row: tuple[float, float, float], rise_time: float) -> sw.Shock:
    profile = sw.PowerLaw(rise_exponent=row[1], decay_exponent=row[2], duration_ratio=row[0])
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time)


def _predict(row: tuple[float, float, float], rise_time: float) -> sw.Outcome:
    return PAPER.predict(_power(row, rise_time), CHAIN)


def _ejection(row: tuple[float, float, float], rise_time: float) -> sw.EjectionOutcome:
    outcome = _predict(row, rise_time)
    assert isinstance(outcome, sw.EjectionOutcome)
    return outcome


def _in_units(units: float, n: float = 2.0) -> sw.Shock:
    """A triangle whose rise time is so many A F0^(-1/6)."""
    return sw.Shock(profile=sw.Triangular(duration_ratio=n), peak_force=FORCE, rise_time=units * TIME)


# ---------------------------------------------------------------- Table 1


TABLE_1 = pytest.mark.parametrize(
    ("row", "relation"),
    [((10, 1, 5), "equal"), ((6, 0.5, 6), "less"), ((4, 0.25, 1), "greater")],
    ids=["row1", "row2", "row3"],
)


@TABLE_1
class TestTable1:
    def test_relation(self, row: tuple[float, float, float], relation: str) -> None:
        assert _predict(row, 15e-6).relation == relation

    def test_it_is_a_train(self, row: tuple[float, float, float], relation: str) -> None:
        assert _predict(row, 15e-6).regime == "train"

    def test_the_trace_states_how_it_was_decided(self, row: tuple[float, float, float], relation: str) -> None:
        decided = {step.outcome: step for step in _predict(row, 15e-6).trace}
        assert decided["train"].left < decided["train"].right
        assert decided[relation].equation == "(5d)"


def test_first_row_compares_24_55_with_24_02_microseconds() -> None:
    step = next(step for step in _predict((10, 1, 5), 15e-6).trace if step.outcome == "equal")
    # The digits that are given.
    assert (round(step.left * 1e6, 2), round(step.right * 1e6, 2)) == (24.55, 24.02)


@pytest.mark.parametrize(
    ("tolerance", "relation"),
    [(0.0, "greater"), (0.0215, "greater"), (0.0225, "equal"), (0.05, "equal"), (0.5, "equal")],
    ids=str,
)
def test_how_near_counts_as_equal_is_the_user_s_choice(tolerance: float, relation: str) -> None:
    # The first row's sides differ by 2.204 %.
    predictor = sw.Predictor(momentum_coefficient="paper", equal_tolerance=tolerance)
    assert predictor.predict(_power((10, 1, 5), 15e-6), CHAIN).relation == relation


@pytest.mark.parametrize("units", [0.96, 1.0, 1.04], ids=str)
def test_sides_within_five_percent_are_equal_unless_told(units: float) -> None:
    # A triangle with n = 2 has the impulse t0.
    assert PAPER.predict(_in_units(units), CHAIN).relation == "equal"


@pytest.mark.parametrize(("units", "relation"), [(0.94, "less"), (1.06, "greater")], ids=["less", "greater"])
def test_sides_beyond_five_percent_are_not_equal(units: float, relation: str) -> None:
    # n = 1.8 keeps the longer one a single wave: its impulse is 0.9 t0, its duration 1.8 t0.
    assert PAPER.predict(_in_units(units / 0.9, n=1.8), CHAIN).relation == relation


# ---------------------------------------------------------------- Table 2


@pytest.mark.parametrize(
    ("row", "rise_time", "virtual", "by_5f", "by_5h"),
    [
        ((3, 0.5, 1), 7.4e-6, 14.414, 44.929, 52.489),
        ((2, 1, 1), 18e-6, 24.024, 70.722, 77.902),
        ((4, 1e-5, 1), 3.6e-6, 9.610, 30.783, 35.994),
        ((6, 0.9, 1), 1.9e-6, 7.938, 17.982, 21.482),
        ((5, 0.25, 1), 2.6e-6, 8.580, 23.866, 28.022),
    ],
    ids=["row1", "row2", "row3", "row4", "row5"],
)
class TestTable2:
    # All figures to the digits given: half a unit of the last.
    def test_virtual_rise_time(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        assert _ejection(row, rise_time).virtual_rise_time * 1e6 == pytest.approx(virtual, abs=5e-4)

    def test_peak_force_by_5h(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        assert _ejection(row, rise_time).peak_force == pytest.approx(by_5h, abs=5e-4)

    def test_peak_force_by_5f_without_the_added_momentum(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        applied = _ejection(row, rise_time).applied_momentum
        uncorrected = (applied / CHAIN.momentum_parameter(13 / 3)) ** 1.2
        assert uncorrected == pytest.approx(by_5f, abs=5e-4)

    def test_5h_is_5f_with_the_added_momentum(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        outcome = _ejection(row, rise_time)
        total = outcome.applied_momentum + outcome.added_momentum
        # Powers and a quotient: rounding.
        assert (total / CHAIN.momentum_parameter(13 / 3)) ** 1.2 == pytest.approx(outcome.peak_force, rel=1e-13)

    def test_added_momentum_is_the_area_under_the_end_of_the_virtual_shock(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        outcome = _ejection(row, rise_time)
        hat, n = outcome.virtual_rise_time, row[0]
        # eta2 = 1 in all rows: the end is a triangle, of height d/((n - 1) t0_hat) over d = t0_hat - t0.
        window = hat - rise_time
        expected = 2 * FORCE * window**2 / (2 * (n - 1) * hat)
        assert outcome.added_momentum == pytest.approx(expected, rel=1e-12)

    def test_relation_is_less(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        assert _ejection(row, rise_time).relation == "less"

    def test_window_ratio(
        self, row: tuple[float, float, float], rise_time: float, virtual: float, by_5f: float, by_5h: float
    ) -> None:
        expected = (virtual - rise_time * 1e6) / (row[0] * virtual)
        assert _ejection(row, rise_time).window_ratio == pytest.approx(expected, abs=2e-5)


def test_the_exact_coefficient_is_used_unless_told() -> None:
    shock = _power((2, 1, 1), 18e-6)
    assert sw.Predictor().predict(shock, CHAIN) == sw.Predictor(momentum_coefficient=4.344507853978653).predict(
        shock, CHAIN
    )


# ---------------------------------------------------------------- the decision table


@pytest.mark.parametrize(
    ("shock", "regime", "equations"),
    [
        # A triangle with n = 2: alphaF0 = 2, impulse t0, duration 2 t0.
        (_in_units(0.5), "ejection", ["(5e)", "(5e)", "4.2.2"]),
        (_in_units(0.999), "ejection", ["(5e)", "(5e)", "4.2.2"]),
        (_in_units(1.001), "train", ["(5d)", "(5d)"]),
        # Steep rise to 0.9 of the area: impulse 1.4 t0, duration 2 t0, alphaF0 = 2 - 0.4^1.5 = 1.747.
        (_power((2, 1 / 9, 1), 0.7 * TIME), "ejection", ["(5e)", "(5e)", "4.2.2"]),
        (_power((2, 1 / 9, 1), 0.75 * TIME), "single", ["(5e)", "(5e)", "4.2.3"]),
        (_power((2, 1 / 9, 1), 0.87 * TIME), "single", ["(5e)", "(5e)", "4.2.3"]),
        (_power((2, 1 / 9, 1), 0.88 * TIME), "train", ["(5d)", "(5d)"]),
        # Long but weak: a train by its duration, though its impulse 0.51 TIME would not make one wave of F0.
        (_power((300, 1, 299), TIME * 0.34), "train", ["(5d)", "(5d)"]),
    ],
    ids=[
        "short-triangle",
        "triangle-just-below",
        "triangle-just-above",
        "steep-ejection",
        "steep-single",
        "steep-single-just-below",
        "steep-train",
        "weak-train",
    ],
)
class TestDecisionTable:
    def test_regime(self, shock: sw.Shock, regime: str, equations: list[str]) -> None:
        assert PAPER.predict(shock, CHAIN).regime == regime

    def test_trace_names_the_equations(self, shock: sw.Shock, regime: str, equations: list[str]) -> None:
        assert [step.equation for step in PAPER.predict(shock, CHAIN).trace] == equations

    def test_trace_holds_times_in_seconds(self, shock: sw.Shock, regime: str, equations: list[str]) -> None:
        trace = PAPER.predict(shock, CHAIN).trace
        assert trace[0].right == pytest.approx(shock.duration, rel=1e-14)
        assert trace[1].right == pytest.approx(TIME, rel=1e-13)

    def test_class_is_that_of_the_regime(self, shock: sw.Shock, regime: str, equations: list[str]) -> None:
        classes = {"ejection": sw.EjectionOutcome, "single": sw.SingleOutcome, "train": sw.TrainOutcome}
        assert type(PAPER.predict(shock, CHAIN)) is classes[regime]


def test_equality_at_both_thresholds_is_a_single_wave() -> None:
    # alphaF0 tA = n t0 = 2 and L = tA = 1, without any rounding.
    profile = sw.Triangular(duration_ratio=2)
    shock = ScaledShock(profile=profile, areas=profile.areas(), rise_time=1.0, momentum_parameter=1.0)
    assert predict(shock, Settings()).regime == "single"


def test_a_single_wave_takes_the_whole_impulse() -> None:
    outcome = PAPER.predict(_power((2, 1 / 9, 1), 0.8 * TIME), CHAIN)
    # (5f) with the impulse 1.4 t0 and A F0^(-1/6) = TIME.
    assert outcome.amplification == pytest.approx((1.4 * 0.8) ** 1.2, rel=1e-12)


def test_a_single_wave_has_no_ejection() -> None:
    assert PAPER.predict(_power((2, 1 / 9, 1), 0.8 * TIME), CHAIN).to_dict()["ejection"] is None


def test_ejection_of_a_triangle_by_hand() -> None:
    outcome = PAPER.predict(_in_units(0.6), CHAIN)
    # t0_hat = TIME, window 0.4 TIME, added 0.4^2 TIME: (0.6 + 0.16)^(6/5).
    assert outcome.amplification == pytest.approx(0.76**1.2, rel=1e-12)


def test_a_wave_stronger_than_the_relation_says_is_warned_of() -> None:
    # A rectangle with n = 1.5: L = 0.6 TIME, and the window of (5h) adds 0.8/1.5 of it at full force.
    outcome = PAPER.predict(_power((1.5, 0, 0), 0.4 * TIME), CHAIN)
    assert outcome.relation == "less"
    assert outcome.amplification == pytest.approx((0.6 + 0.8 / 1.5) ** 1.2, rel=1e-12)
    assert any("(5h)" in warning for warning in outcome.warnings)
