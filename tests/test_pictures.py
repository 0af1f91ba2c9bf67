"""Pictures: what is drawn is what was found, in units that the axes name; files are the same on every run."""

import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from attrs import evolve
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

import shockwave as sw
from scenes import CASE_B, CHAIN, FORCE, UNITS, power, triangle
from shockwave import pictures

ROOT = Path(__file__).parent.parent


class Run(NamedTuple):
    """A run of a method."""

    method: str
    error: float | None
    seconds: float | None
    problem: str = ""


HAMMER = sw.load_scenario(ROOT / "profiles" / "examples" / "hammer.yaml").shock.profile
#: An ejection, two trains of which one has more than twenty waves, a record, and the extremes.
SHOCKS = {
    "ejection": power(0.5),
    "train": triangle(9.0),
    "long train": CASE_B,
    "record": sw.Shock(profile=HAMMER, peak_force=FORCE, rise_time=3 * UNITS.time),
    "tiny": sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1e-9, rise_time=1e-12),
    "long decay": sw.Shock(
        profile=sw.PowerLaw(rise_exponent=1e-5, decay_exponent=50, duration_ratio=1e4),
        peak_force=FORCE,
        rise_time=1e-2 * UNITS.time,
    ),
}
RUNS = (
    Run("rk4", 1e-3, 0.01),
    Run("rk4", 1e-6, 0.1),
    Run("formula", 0.02, 1e-5),
    Run("rk4", 0.0, 1.0),
    Run("formula", None, 2e-5, "no wave"),
    Run("other", None, None, "not installed"),
)
X, N = np.geomspace(0.5, 30, 12), np.geomspace(1.5, 20, 10)
ERRORS = np.log(np.outer(X, N) / 20) / 5
REGIMES = np.where(np.outer(X, np.ones(10)) < 4, "ejection", "train")


@cache
def compared(name: str) -> sw.Comparison:
    return sw.compare(SHOCKS[name], CHAIN)


@cache
def recorded(name: str, *record: Any) -> sw.SimulationResult:
    contacts = range(45) if "forces" in record else [8]
    return sw.simulate(SHOCKS[name], CHAIN, contacts=contacts, record=record)


RATIOS = np.geomspace(0.3, 3, 5)
#: Picture -> how it is drawn of a shock.
PICTURES: dict[str, Any] = {
    "pulse": lambda ax, name: pictures.pulse(ax, SHOCKS[name]),
    "conditions": lambda ax, name: pictures.conditions(ax, SHOCKS[name]),
    "contact_forces": lambda ax, name: pictures.contact_forces(ax, recorded(name, "forces")),
    "space_time": lambda ax, name: pictures.space_time(ax, recorded(name, "forces")),
    "train": lambda ax, name: pictures.train(ax, compared(name)),
    "approach": lambda ax, name: pictures.approach(ax, compared(name).simulated),
    "energy": lambda ax, name: pictures.balance(ax, recorded(name, "energies")),
    "momentum": lambda ax, name: pictures.balance(ax, recorded(name, "field"), of="momentum"),
    "amplification": lambda ax, name: pictures.amplification(
        ax, SHOCKS[name].profile, sw.Predictor(), CHAIN, rise_times=RATIOS
    ),
    "correction": lambda ax, name: pictures.correction_area(ax, SHOCKS[name], compared(name).predicted),
    "work_precision": lambda ax, _: pictures.work_precision(ax, RUNS),
    "trust_map": lambda ax, _: pictures.trust_map(ax, X, N, ERRORS, REGIMES),
}
#: The labels with units of their axes for the ejection.
LABELS = {
    "pulse": ("time (µs)", "force (N)"),
    "contact_forces": ("time (µs)", "contact force (N)"),
    "space_time": ("time (µs)", "contact"),
    "train": ("wave", "peak force (N)"),
    "energy": ("time (µs)", "energy (µJ)"),
    "momentum": ("time (µs)", "momentum (mN s)"),
    "work_precision": ("time (s)", "relative error"),
}
OF_OTHER_SHOCKS = [
    pytest.param(picture, name, marks=pytest.mark.slow)
    for picture in list(PICTURES)[:-3]
    for name in list(SHOCKS)[1:]
    if (picture, name) != ("amplification", "long decay")
]


@pytest.fixture
def ax() -> Axes:
    return pictures.figure()[1][0]


def line(ax: Axes, label: str) -> Line2D:
    (found,) = (one for one in ax.get_lines() if one.get_label() == label)
    return found


def labels(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def y_of(one: Line2D) -> np.ndarray:
    return np.asarray(one.get_ydata(), dtype=float)


def x_of(one: Line2D) -> np.ndarray:
    return np.asarray(one.get_xdata(), dtype=float)


@pytest.mark.parametrize(("picture", "name"), [*((picture, "ejection") for picture in PICTURES), *OF_OTHER_SHOCKS])
def test_nothing_leaves_the_figure(picture: str, name: str) -> None:
    figure, (ax,) = pictures.figure()
    assert PICTURES[picture](ax, name) is ax
    if name == "ejection" and picture in LABELS:
        assert (ax.get_xlabel(), ax.get_ylabel()) == LABELS[picture]
    figure.draw_without_rendering()
    around = ax.get_tightbbox()
    assert around is not None
    # a pixel of slack for the rounding of letters
    assert min(around.x0, around.y0) > -1
    assert around.x1 < figure.bbox.width + 1
    assert around.y1 < figure.bbox.height + 1
    # the picture itself keeps a third of the figure at least
    assert ax.get_window_extent().width > figure.bbox.width / 3
    assert ax.get_window_extent().height > figure.bbox.height / 3


def test_ticks_are_written_in_the_unit_of_the_label(ax: Axes) -> None:
    pictures.pulse(ax, sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=2e3, rise_time=1e-6))
    assert ax.get_ylabel() == "force (kN)"
    assert ax.yaxis.get_major_formatter()(1500.0, 0) == "1.5"


def test_names_in_an_svg_begin_with_its_own() -> None:
    figure, (ax,) = pictures.figure()
    pictures.pulse(ax, SHOCKS["ejection"])
    root = ET.fromstring(pictures.svg(figure, "one", 'a "sharp" <shock>'))
    named = {element.get("id", "") for element in root.iter() if element.get("id")}
    assert named
    assert all(name.startswith("one-") for name in named)
    href = "{http://www.w3.org/1999/xlink}href"
    assert {element.get(href, "").removeprefix("#") for element in root.iter() if element.get(href)} <= named
    assert root.get("aria-label") == 'a "sharp" <shock>'


@pytest.mark.parametrize(("kind", "head"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_files_have_the_format_of_their_ending_and_are_the_same_twice(tmp_path: Path, kind: str, head: bytes) -> None:
    for name in ("one", "two"):
        figure, (left, right) = pictures.figure(1, 2)
        pictures.train(left, compared("train"))
        pictures.trust_map(right, X, N, ERRORS, REGIMES)
        pictures.save(figure, tmp_path / f"{name}.{kind}")
    first, second = ((tmp_path / f"{name}.{kind}").read_bytes() for name in ("one", "two"))
    assert first.startswith(head)
    assert first == second
    # two files of one second would agree even if they were dated
    assert b"CreationDate" not in first
    assert b"dc:date" not in first


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pictures.figure(size="huge"), r"^size: must be column, page or"),
        (lambda: pictures.save(pictures.figure()[0], "a.gif"), r"^file: must end in \.svg, \.png, \.pdf"),
        (lambda: pictures.svg(pictures.figure()[0], 'a"b'), r"^name: must be a letter"),
        (lambda: pictures.save(pictures.figure()[0], "nowhere/a.svg"), r"^nowhere/a.svg: cannot be written"),
    ],
    ids=["size", "ending", "name", "folder"],
)
def test_wrong_sizes_and_places_are_refused(call: Any, message: str) -> None:
    with pytest.raises(sw.ShockwaveError, match=message):
        call()


def test_a_pulse_has_the_force_and_the_areas_of_the_shock(ax: Axes) -> None:
    shock = SHOCKS["ejection"]
    pictures.pulse(ax, shock)
    drawn = ax.get_lines()[0]
    # the time has been multiplied by the rise time and is divided by it here, which rounds
    force = FORCE * shock.profile.force(np.clip(x_of(drawn) / shock.rise_time, 0, 3))
    assert y_of(drawn) == pytest.approx(force, abs=1e-12 * FORCE)
    assert y_of(drawn).max() == FORCE
    # a1 = 1/(1 + eta1), a2 = (n - 1)/(1 + eta2)
    assert labels(ax) == ["rise, $a_1$ = 0.6667 $F_0 t_0$", "decay, $a_2$ = 1 $F_0 t_0$"]


def test_margins_are_those_of_the_conditions(ax: Axes) -> None:
    # a1 = 1/3, a2 = 1, n = 4: 1 - 1/3, 1/3 - 1/2, 3/2 - 1
    profile = sw.PowerLaw(rise_exponent=2, decay_exponent=2, duration_ratio=4)
    pictures.conditions(ax, sw.Shock(profile=profile, peak_force=1.0, rise_time=1.0))
    margins = [text.get_text().partition("\n")[2] for text in ax.get_yticklabels()]
    assert margins == ["+0.6667 $t_0$, holds", "\N{MINUS SIGN}0.1667 $t_0$, fails", "+0.5 $t_0$, holds"]
    ends = [float(x) for one in ax.get_lines() if one.get_marker() in ("o", "X") for x in x_of(one)]
    assert ends == pytest.approx([0.5, -0.2, 0.2])


def test_the_added_area_is_half_of_the_added_momentum(ax: Axes) -> None:
    outcome = compared("ejection").predicted
    assert isinstance(outcome, sw.EjectionOutcome)
    pictures.correction_area(ax, SHOCKS["ejection"], outcome)
    (area,) = ax.collections
    x, y = np.asarray(area.get_paths()[0].vertices).T
    # the shoelace formula; the decay is a straight line, so that the area has no error but rounding
    drawn = abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2
    assert 2 * drawn == pytest.approx(outcome.added_momentum, rel=1e-9)


def test_contact_forces_are_those_recorded(ax: Axes) -> None:
    result: Any = recorded("ejection", "forces")
    pictures.contact_forces(ax, result)
    # six of 45
    assert labels(ax) == ["shock", *(f"contact {contact}" for contact in (0, 9, 18, 26, 35, 44))]
    assert np.array_equal(y_of(line(ax, "contact 18")), result.recording.forces[:, 18])
    assert np.array_equal(x_of(line(ax, "contact 18")), result.recording.times)
    assert y_of(line(ax, "shock")).max() == FORCE
    assert x_of(line(ax, "shock"))[-1] == SHOCKS["ejection"].duration


def test_long_histories_keep_their_peaks_in_a_map(ax: Axes) -> None:
    interval = UNITS.time / 200
    result: Any = sw.simulate(SHOCKS["ejection"], CHAIN, contacts=range(5), record=["forces"], interval=interval)
    pictures.space_time(ax, result)
    drawn = np.asarray(ax.collections[0].get_array())
    assert drawn.shape[1] < 500 < len(result.recording.times)
    assert np.array_equal(drawn.max(axis=1), result.recording.forces.max(axis=0))


def test_fronts_run_through_where_waves_were_read(ax: Axes) -> None:
    result = recorded("train", "forces")
    pictures.space_time(ax, result)
    front, wave = line(ax, "front 2"), result.waves[1]
    (x0, x1), (y0, y1) = x_of(front), y_of(front)
    assert (y1 - y0) / (x1 - x0) * 2 * CHAIN.radius == pytest.approx(wave.speed)
    assert x0 + (wave.contact - y0) * (x1 - x0) / (y1 - y0) == pytest.approx(wave.arrival_time)


@pytest.mark.parametrize("name", ["ejection", "train", pytest.param("long train", marks=pytest.mark.slow)])
def test_trains_are_those_predicted_and_simulated(ax: Axes, name: str) -> None:
    comparison = compared(name)
    pictures.train(ax, comparison)
    assert y_of(line(ax, "predicted")).tolist() == [wave.peak_force for wave in comparison.predicted.waves]
    settled = [wave.peak_force for wave in comparison.simulated.waves if wave.error_estimate is not None]
    assert y_of(line(ax, "simulated")).tolist() == settled
    assert set(y_of(line(ax, "shock"))) == {FORCE}


@pytest.mark.parametrize("bounds", [None, (-0.2, 0.25), (-1.0, 0.25)], ids=["unknown", "range", "no-upper-end"])
def test_a_bar_is_where_the_simulated_force_is_expected(ax: Axes, bounds: tuple[float, float] | None) -> None:
    comparison = compared("ejection")
    predicted = comparison.predicted.peak_force
    pictures.train(ax, evolve(comparison, predicted=evolve(comparison.predicted, expected_error=bounds)))
    assert ("expected" in labels(ax)) is (bounds is not None)
    if bounds is not None:
        highest = ax.get_ylim()[1] if bounds[0] == -1.0 else predicted / 0.8
        assert y_of(line(ax, "expected")) == pytest.approx([predicted / 1.25, highest])


def test_the_approach_is_that_of_the_passages_up_to_where_the_wave_was_read(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["ejection"], evolve(CHAIN, granules=12))
    pictures.approach(ax, result)
    found = dict(line(ax, "distance").get_xydata().tolist())
    assert sorted(found) == list(range(result.primary.contact))
    assert found[2] == pytest.approx(abs(result.passage(2).peak_force / result.peak_force - 1))


@pytest.mark.parametrize("name", ["ejection", "train", "record", "tiny"])
def test_the_work_of_the_shock_is_the_energy_in_the_chain(ax: Axes, name: str) -> None:
    result: Any = recorded(name, "energies")
    pictures.balance(ax, result)
    energy, work = (y_of(line(ax, label)) for label in ("sum", "work of shock"))
    assert np.array_equal(energy, result.recording.kinetic_energy + result.recording.contact_energy)
    # the error of the simulation, at its default tolerance of 1e-6
    assert work == pytest.approx(energy[[-1, -1]], rel=1e-5)


@pytest.mark.parametrize("name", ["ejection", "train", "record"])
def test_the_momentum_of_the_granules_is_the_impulse(ax: Axes, name: str) -> None:
    pictures.balance(ax, recorded(name, "field"), of="momentum")
    total, impulse = (y_of(line(ax, label)) for label in ("sum", "impulse of shock"))
    # rounding, but for the output of a record between steps
    assert total == pytest.approx(impulse, abs=1e-9 * impulse[-1])


def test_amplifications_are_those_simulated_and_predicted(ax: Axes) -> None:
    profile, ratios = sw.Triangular(duration_ratio=3), [0.2, 1.0, 4.0]
    pictures.amplification(ax, profile, sw.Predictor(), CHAIN, rise_times=ratios)
    shocks = [triangle(3 * ratio) for ratio in ratios]
    simulated = [sw.simulate(shock, CHAIN).amplification for shock in shocks]
    assert y_of(line(ax, "simulated")) == pytest.approx(simulated, rel=1e-9)
    assert y_of(line(ax, "predicted"))[0] == pytest.approx(sw.Predictor().predict(shocks[0], CHAIN).amplification)
    borders = [x_of(one)[0] for one in ax.get_lines() if one.get_linestyle() == "--"]
    # alphaF0 tA = n t0, 4.1, with alphaF0 = 2 for a triangle and tA = 1.652066518648 T0; S is 1 there, too;
    # borders are halfway between two predictions, which are 20^(1/240) apart
    assert borders == pytest.approx([2 * 1.652066518648 / 3], rel=0.0065)


def test_runs_are_joined_by_method_and_failed_ones_counted(ax: Axes) -> None:
    pictures.work_precision(ax, RUNS)
    assert labels(ax) == ["rk4", "formula (1 failed)", "other (1 failed)"]
    assert x_of(line(ax, "rk4")).tolist() == [0.01, 0.1, 1.0]
    # an error of zero is drawn where rounding begins
    assert y_of(line(ax, "rk4")).tolist() == [1e-3, 1e-6, 1e-16]


def test_a_map_of_trust_holds_the_errors(ax: Axes) -> None:
    errors = ERRORS.copy()
    errors[3, 4] = np.nan
    pictures.trust_map(ax, X, N, errors, REGIMES)
    drawn: Any = np.ma.asarray(ax.collections[0].get_array())
    assert np.array_equal(drawn.filled(np.nan), errors.T, equal_nan=True)
    assert {text.get_text() for text in ax.texts} == {"ejection", "train"}


REFUSED: dict[str, Any] = {
    r"record: must have forces \(got nothing; simulate with record=\['forces'\]": lambda ax: pictures.contact_forces(
        ax, recorded("ejection")
    ),
    r"record: must have energies \(got field": lambda ax: pictures.balance(ax, recorded("ejection", "field")),
    r"contacts: must be among those recorded, 0, 1, .*got 99": lambda ax: pictures.contact_forces(
        ax, recorded("ejection", "forces"), contacts=[99]
    ),
    r"outcome: must be an ejection.*got train": lambda ax: pictures.correction_area(
        ax, SHOCKS["train"], compared("train").predicted
    ),
    r"rise_times: must be two or more": lambda ax: pictures.amplification(
        ax, HAMMER, sw.Predictor(), CHAIN, rise_times=[1.0]
    ),
}


@pytest.mark.parametrize("message", REFUSED, ids=lambda message: message[:24])
def test_data_that_cannot_be_drawn_are_refused(ax: Axes, message: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=f"^{message}"):
        REFUSED[message](ax)
