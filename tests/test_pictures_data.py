"""Pictures: what is drawn is what was found, in SI units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from attrs import evolve
from matplotlib.axes import Axes

import shockwave as sw
from drawings import ERRORS, REGIMES, RUNS, SHOCKS, N, Run, X, compared, labels, line, recorded, x_of, y_of
from scenes import CHAIN, FORCE, UNITS, power
from shockwave import pictures
from shockwave.pictures.axes import thinned


@pytest.fixture
def ax() -> Axes:
    return pictures.figure()[1][0]


def test_pulse_has_the_force_of_the_shock(ax: Axes) -> None:
    shock = SHOCKS["ejection"]
    pictures.pulse(ax, shock)
    drawn = ax.get_lines()[0]
    # the time has been multiplied by the rise time and is divided by it here, which rounds
    force = FORCE * shock.profile.force(np.clip(x_of(drawn) / shock.rise_time, 0, 3))
    assert y_of(drawn) == pytest.approx(force, abs=1e-12 * FORCE)
    assert y_of(drawn).max() == FORCE


def test_areas_are_told_in_the_key(ax: Axes) -> None:
    pictures.pulse(ax, SHOCKS["ejection"])
    # a1 = 1/(1 + eta1), a2 = (n - 1)/(1 + eta2)
    assert labels(ax) == ["rise, $a_1$ = 0.6667 $F_0 t_0$", "decay, $a_2$ = 1 $F_0 t_0$"]


def test_margins_are_those_of_the_conditions(ax: Axes) -> None:
    # a1 = 1/3, a2 = 1, n = 4: 1 - 1/3, 1/3 - 1/2, 3/2 - 1
    profile = sw.PowerLaw(rise_exponent=2, decay_exponent=2, duration_ratio=4)
    pictures.conditions(ax, sw.Shock(profile=profile, peak_force=1.0, rise_time=1.0))
    told = [text.get_text().partition("\n")[2] for text in ax.get_yticklabels()]
    assert told == ["+0.6667 $t_0$, holds", "\N{MINUS SIGN}0.1667 $t_0$, fails", "+0.5 $t_0$, holds"]
    ends = [float(y) for one in ax.get_lines() if one.get_marker() in ("o", "X") for y in x_of(one)]
    assert ends == pytest.approx([0.5, -0.2, 0.2])


def test_lines_are_the_recorded_forces(ax: Axes) -> None:
    result = recorded("ejection", "forces")
    pictures.contact_forces(ax, result, contacts=[3, 20])
    kept = result.recording
    assert kept is not None
    assert kept.forces is not None
    assert np.array_equal(y_of(line(ax, "contact 20")), kept.forces[:, 20])
    assert np.array_equal(x_of(line(ax, "contact 3")), kept.times)


def test_shock_beside_contact_forces_reaches_its_peak(ax: Axes) -> None:
    pictures.contact_forces(ax, recorded("ejection", "forces"))
    assert y_of(line(ax, "shock")).max() == FORCE
    assert x_of(line(ax, "shock"))[-1] == SHOCKS["ejection"].duration


def test_of_many_contacts_six_are_drawn(ax: Axes) -> None:
    pictures.contact_forces(ax, recorded("ejection", "forces"))
    assert labels(ax) == ["shock", *(f"contact {contact}" for contact in (0, 9, 18, 26, 35, 44))]


def test_map_holds_the_recorded_forces(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["ejection"], CHAIN, contacts=range(12), record=["forces"])
    pictures.space_time(ax, result)
    (mesh,) = ax.collections
    assert result.recording is not None
    assert result.recording.forces is not None
    assert np.array_equal(np.asarray(mesh.get_array()), result.recording.forces.T)


def test_map_of_a_field_holds_the_same_forces(ax: Axes) -> None:
    asked: Any = ((range(12), ["forces"]), ((), ["field"]))
    forces, both = (
        sw.simulate(SHOCKS["ejection"], CHAIN, contacts=contacts, record=record, until=20 * UNITS.time)
        for contacts, record in asked
    )
    pictures.space_time(ax, both)
    drawn = np.asarray(ax.collections[0].get_array())[:12]
    assert forces.recording is not None
    assert forces.recording.forces is not None
    # a difference of displacements some 1e3 times as large, in units of their roundings
    assert drawn == pytest.approx(forces.recording.forces.T, abs=1e-9 * FORCE)


@pytest.mark.parametrize("number", [1, 2])
def test_fronts_run_through_where_waves_were_read(ax: Axes, number: int) -> None:
    result = recorded("train", "forces")
    pictures.space_time(ax, result)
    front, wave = line(ax, f"front {number}"), result.waves[number - 1]
    (x0, x1), (y0, y1) = x_of(front), y_of(front)
    assert wave.speed is not None
    assert (y1 - y0) / (x1 - x0) * 2 * CHAIN.radius == pytest.approx(wave.speed)
    assert x0 + (wave.contact - y0) * (x1 - x0) / (y1 - y0) == pytest.approx(wave.arrival_time)


def test_long_histories_keep_their_peaks_in_a_map(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["ejection"], CHAIN, contacts=range(5), record=["forces"], interval=UNITS.time / 200)
    pictures.space_time(ax, result)
    drawn = np.asarray(ax.collections[0].get_array())
    assert result.recording is not None
    assert result.recording.forces is not None
    assert drawn.shape[1] < 500 < len(result.recording.times)
    assert np.array_equal(drawn.max(axis=1), result.recording.forces.max(axis=0))


@pytest.mark.parametrize("name", ["ejection", "train", pytest.param("long train", marks=pytest.mark.slow)])
def test_trains_are_those_predicted_and_simulated(ax: Axes, name: str) -> None:
    comparison = compared(name)
    pictures.train(ax, comparison)
    assert y_of(line(ax, "predicted")).tolist() == [wave.peak_force for wave in comparison.predicted.waves]
    settled = [wave.peak_force for wave in comparison.simulated.waves if wave.error_estimate is not None]
    assert y_of(line(ax, "simulated")).tolist() == settled
    assert set(y_of(line(ax, "shock"))) == {FORCE}


def expecting(bounds: tuple[float, float] | None) -> sw.Comparison:
    comparison = compared("ejection")
    return evolve(comparison, predicted=evolve(comparison.predicted, expected_error=bounds))


def test_bar_is_where_the_simulated_force_is_expected(ax: Axes) -> None:
    pictures.train(ax, expecting((-0.2, 0.25)))
    predicted = compared("ejection").predicted.peak_force
    assert y_of(line(ax, "expected")) == pytest.approx([predicted / 1.25, predicted / 0.8])


def test_without_a_known_range_there_is_no_bar(ax: Axes) -> None:
    pictures.train(ax, expecting(None))
    assert labels(ax) == ["shock", "predicted", "simulated"]


def test_range_without_an_upper_end_is_an_arrow(ax: Axes) -> None:
    pictures.train(ax, expecting((-1.0, 0.25)))
    assert [one.get_marker() for one in ax.get_lines()].count("^") == 1
    assert y_of(line(ax, "expected"))[1] < ax.get_ylim()[1]


def test_added_area_is_half_of_the_added_momentum(ax: Axes) -> None:
    outcome = compared("ejection").predicted
    assert isinstance(outcome, sw.EjectionOutcome)
    pictures.correction_area(ax, SHOCKS["ejection"], outcome)
    (area,) = ax.collections
    x, y = np.asarray(area.get_paths()[0].vertices).T
    # the shoelace formula; the decay is a straight line, so that the area has no error but rounding
    drawn = abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2
    assert 2 * drawn == pytest.approx(outcome.added_momentum, rel=1e-9)


def test_correction_of_a_train_is_refused(ax: Axes) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^outcome: must be an ejection.*got train"):
        pictures.correction_area(ax, SHOCKS["train"], compared("train").predicted)


def test_approach_is_that_of_the_passages(ax: Axes) -> None:
    result = compared("train").simulated
    pictures.approach(ax, result, contacts=[5, 10])
    told = [abs(result.passage(contact).peak_force / result.peak_force - 1) for contact in (5, 10)]
    drawn = np.concatenate([y_of(one) for one in ax.get_lines() if "the limit" in str(one.get_label())])
    assert drawn == pytest.approx(told)


def test_approach_of_a_short_chain_is_to_where_it_was_read(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["ejection"], evolve(CHAIN, granules=12))
    pictures.approach(ax, result)
    drawn = np.concatenate([x_of(one) for one in ax.get_lines() if "the limit" in str(one.get_label())])
    assert sorted(drawn) == list(range(result.primary.contact))


def test_energy_is_that_recorded(ax: Axes) -> None:
    result = recorded("ejection", "energies")
    pictures.books(ax, result)
    kept = result.recording
    assert kept is not None
    assert kept.kinetic_energy is not None
    assert kept.contact_energy is not None
    assert np.array_equal(y_of(line(ax, "sum")), kept.kinetic_energy + kept.contact_energy)
    work = result.found.work * result.scales.energy
    assert set(y_of(line(ax, "work of shock"))) == {work}


@pytest.mark.parametrize("name", ["ejection", "train", "record", "tiny"])
def test_work_of_the_shock_is_the_energy_in_the_chain(ax: Axes, name: str) -> None:
    result = recorded(name, "field", "energies")
    pictures.books(ax, result)
    energy, work = (y_of(line(ax, label)) for label in ("sum", "work of shock"))
    # samples are a tenth of the natural time apart: the impulse of the tiny shock comes within the first of them
    assert work == pytest.approx(energy, abs=3e-4 * energy[-1])


@pytest.mark.parametrize("name", ["ejection", "train", "record"])
def test_momentum_of_the_granules_is_the_impulse(ax: Axes, name: str) -> None:
    pictures.books(ax, recorded(name, "field"), of="momentum")
    total, impulse = (y_of(line(ax, label)) for label in ("sum", "impulse of shock"))
    # rounding, but for the output of a record between steps
    assert total == pytest.approx(impulse, abs=1e-9 * impulse[-1])


def test_amplifications_are_those_simulated_and_predicted(ax: Axes) -> None:
    profile, ratios = SHOCKS["ejection"].profile, [0.2, 1.0, 4.0]
    pictures.amplification(ax, profile, sw.Predictor(), CHAIN, peak_force=FORCE, rise_times=ratios)
    shocks = [power(ratio) for ratio in ratios]
    told = [sw.simulate(shock, CHAIN).amplification for shock in shocks]
    assert y_of(line(ax, "simulated")) == pytest.approx(told, rel=1e-9)
    assert y_of(line(ax, "predicted"))[0] == pytest.approx(sw.Predictor().predict(shocks[0], CHAIN).amplification)


def test_regimes_border_where_the_prediction_changes(ax: Axes) -> None:
    profile = sw.Triangular(duration_ratio=3)
    pictures.amplification(ax, profile, sw.Predictor(), CHAIN, peak_force=FORCE, rise_times=[0.2, 1.0, 4.0])
    borders = [x_of(one)[0] for one in ax.get_lines() if one.get_linestyle() == "--"]
    # alphaF0 tA = n t0, 4.1, with alphaF0 = 2 for a triangle and tA = 1.652066518648 T0; S is 1 there, too
    assert borders == pytest.approx([2 * 1.652066518648 / 3], rel=1e-9)


def test_one_rise_time_is_not_a_curve(ax: Axes) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^rise_times: must be two or more"):
        pictures.amplification(ax, SHOCKS["ejection"].profile, sw.Predictor(), CHAIN, rise_times=[1.0])


def test_runs_of_a_method_are_joined(ax: Axes) -> None:
    pictures.work_precision(ax, RUNS)
    assert x_of(line(ax, "rk4")).tolist() == [0.01, 0.1]
    assert y_of(line(ax, "rk4")).tolist() == [1e-3, 1e-6]


def test_failed_runs_are_marked_above_all_errors(ax: Axes) -> None:
    pictures.work_precision(ax, RUNS)
    crosses = [one for one in ax.get_lines() if one.get_marker() == "x"]
    assert [x for one in crosses for x in x_of(one)] == [2e-5]
    assert min(y for one in crosses for y in y_of(one)) > 0.02
    assert labels(ax) == ["rk4", "formula (1 failed)", "other (1 failed)"]


def test_runs_without_an_error_are_marked_below_all_errors(ax: Axes) -> None:
    pictures.work_precision(ax, RUNS)
    triangles = [
        one for one in ax.get_lines() if one.get_marker() == "v" and len(x_of(one)) and one.get_linestyle() != "--"
    ]
    assert [x for one in triangles for x in x_of(one)] == [1.0]
    assert max(y for one in triangles for y in y_of(one)) < 1e-6


@pytest.mark.parametrize("rows", [[], [Run("other", None, None, "not installed")]], ids=["none", "failed"])
def test_runs_of_which_none_succeeded_are_drawn(ax: Axes, rows: list[Run]) -> None:
    assert pictures.work_precision(ax, rows) is ax


def test_map_of_trust_holds_the_errors(ax: Axes) -> None:
    errors = ERRORS.copy()
    errors[3, 4] = np.nan
    pictures.trust_map(ax, X, N, errors, REGIMES)
    drawn: Any = np.ma.asarray(ax.collections[0].get_array())
    assert np.array_equal(drawn.filled(np.nan), errors.T, equal_nan=True)
    assert {text.get_text() for text in ax.texts} == {"ejection", "train"}


def test_map_of_trust_of_another_shape_is_refused(ax: Axes) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^regime: must have the shape .*12, 10"):
        pictures.trust_map(ax, X, N, ERRORS, REGIMES.T)


@pytest.mark.parametrize(
    ("record", "draw", "told"),
    [
        ((), pictures.contact_forces, r"must have forces \(got nothing; simulate with record=\['forces'\], contacts="),
        (("energies",), pictures.space_time, r"must have forces or field \(got energies"),
        (("field",), pictures.books, r"must have energies \(got field"),
    ],
    ids=["forces", "map", "books"],
)
def test_what_was_not_recorded_is_asked_for(ax: Axes, record: Any, draw: Any, told: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=rf"^record: {told}"):
        draw(ax, sw.simulate(SHOCKS["ejection"], CHAIN, record=record))


def test_contact_that_was_not_recorded_is_refused(ax: Axes) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^contacts: must be among those recorded, 0, 1, .*got 99"):
        pictures.contact_forces(ax, recorded("ejection", "forces"), contacts=[99])


def test_thinned_lines_keep_their_extremes() -> None:
    y = np.sin(np.arange(10_000.0))
    y[[1234, 8765]] = 7.0, -9.0
    x, kept = thinned(np.arange(10_000), y, most=300)
    assert len(x) <= 302
    assert (kept.max(), kept.min(), x[0], x[-1]) == (7.0, -9.0, 0.0, 9999.0)
