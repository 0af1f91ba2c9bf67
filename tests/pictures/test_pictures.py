"""Pictures: drawn values agree with the data, axes have units, and files are reproducible."""

import itertools
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace as Run
from typing import Any

import matplotlib
import numpy as np
import pytest
from attrs import evolve
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

import shockwave as sw
from shockwave import pictures
from shockwave.pictures.picture_elements import COLOURS, label_axis
from shockwave.studies.amplification_curve import UniversalCurve
from support.figures import inside, key_of
from support.scenes import CHAIN, FORCE, UNITS, power, triangle
from support.slow_cases import keeping

ROOT = Path(__file__).parents[2]
HAMMER = sw.load_scenario(ROOT / "profiles" / "examples" / "hammer.yaml").shock.profile
#: An ejection, a train, a record, and a shock that ends before the first granule moves.
SHOCKS = {
    "ejection": power(0.5),
    "train": triangle(9.0),
    "record": sw.Shock(profile=HAMMER, peak_force=FORCE, rise_time=3 * UNITS.time),
    "tiny": sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1e-9, rise_time=1e-12),
}
RUNS = (
    Run(method="rk4", error=1e-3, seconds=0.01, problem=""),
    Run(method="formula", error=0.02, seconds=1e-5, problem=""),
    Run(method="rk4", error=0.0, seconds=1.0, problem=""),
    Run(method="formula", error=None, seconds=2e-5, problem="no wave"),
    Run(method="other", error=None, seconds=None, problem="not installed"),
)


@cache
def compared(name: str) -> sw.Comparison:
    return sw.compare(SHOCKS[name], CHAIN)


def section4(name: str) -> Any:
    return compared(name).predicted.section4


@cache
def recorded(name: str, *record: Any) -> Any:
    contacts = range(45) if "forces" in record else [8]
    return sw.simulate(SHOCKS[name], CHAIN, contacts=contacts, record=record)


@cache
def in_finite_chain(kind: str) -> sw.Simulation:
    """A result of ten granules before a wall that a shock or a striker hits."""
    excitation = SHOCKS["train"] if kind == "shock" else sw.Impact(velocity=0.5)
    chain = evolve(CHAIN, granules=10, end=sw.Wall(material="same"))
    return sw.simulate(excitation, chain, record=["forces", "energies", "field"])


#: Functions that draw each picture for a shock.
PICTURES: dict[str, Any] = {
    "pulse": lambda ax, name: pictures.pulse(SHOCKS[name], ax=ax),
    "contact_forces": lambda ax, name: pictures.contact_forces(recorded(name, "forces"), ax=ax),
    "space_time": lambda ax, name: pictures.space_time(recorded(name, "forces"), ax=ax),
    "train": lambda ax, name: pictures.train(compared(name), ax=ax),
    "approach": lambda ax, name: pictures.approach(compared(name).simulated, ax=ax),
    "energy": lambda ax, name: pictures.balance(recorded(name, "energies"), ax=ax),
    "amplification": lambda ax, name: pictures.universal_curves({name: curve(name)}, mark=1.0, ax=ax),
    "correction": lambda ax, _: pictures.correction_area(SHOCKS["ejection"], section4("ejection"), ax=ax),
    "work_precision": lambda ax, _: pictures.work_precision(RUNS, ax=ax),
}
#: Axis labels with units for the ejection.
LABELS = {
    "pulse": ("time (µs)", "force (N)"),
    "energy": ("time (µs)", "energy (µJ)"),
}


@cache
def curve(name: str) -> UniversalCurve:
    return UniversalCurve(SHOCKS[name].profile, rtol=1e-2)


@pytest.fixture
def ax() -> Axes:
    return pictures.figure()[1][0]


def line(ax: Axes, label: str) -> tuple[np.ndarray, np.ndarray]:
    """Abscissae and ordinates of the line with this label."""
    (found,) = (one for one in ax.get_lines() if one.get_label() == label)
    x, y = found.get_xydata().T  # type: ignore[union-attr]
    return x, y


@pytest.mark.parametrize("name", keeping(list(SHOCKS)[:3], "ejection"))
@pytest.mark.parametrize("picture", PICTURES)
def test_pictures_fit_the_figure(picture: str, name: str) -> None:
    figure, (ax,) = pictures.figure()
    assert PICTURES[picture](ax, name) is ax
    if name == "ejection" and picture in LABELS:
        assert (ax.get_xlabel(), ax.get_ylabel()) == LABELS[picture]
    assert inside(figure)
    # the axes take at least a third of the figure
    assert ax.get_window_extent().width > figure.bbox.width / 3
    assert ax.get_window_extent().height > figure.bbox.height / 3


@pytest.mark.parametrize(("kind", "head"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_files_have_the_requested_format_and_are_reproducible(tmp_path: Path, kind: str, head: bytes) -> None:
    for name in ("one", "two"):
        figure, (ax,) = pictures.figure()
        pictures.space_time(recorded("train", "forces"), ax=ax)
        pictures.save(figure, tmp_path / f"{name}.{kind}")
    first, second = ((tmp_path / f"{name}.{kind}").read_bytes() for name in ("one", "two"))
    assert first.startswith(head)
    assert first == second
    # files written in the same second would agree even with dates
    assert b"CreationDate" not in first
    assert b"dc:date" not in first


def test_the_settings_of_a_user_do_not_change_a_figure() -> None:
    def drawn() -> str:
        figure, (left, right) = pictures.figure(1, 2)
        pictures.train(compared("train"), ax=left)
        pictures.pulse(SHOCKS["ejection"], ax=right)
        return pictures.svg(figure)

    expected = drawn()
    settings = {"figure.facecolor": "black", "savefig.facecolor": "black", "axes.facecolor": "black"}
    settings |= {"text.usetex": True, "text.color": "white", "lines.linewidth": 9, "font.family": "monospace"}
    settings |= {"font.size": 30, "savefig.bbox": "tight", "axes.labelcolor": "white", "legend.frameon": True}
    with matplotlib.rc_context(settings):
        assert drawn() == expected
        assert matplotlib.rcParams["text.usetex"]
        # the axes of a figure of the user have the settings of the user
        other = Figure().subplots()
        pictures.pulse(SHOCKS["ejection"], ax=other)
        assert other.title.get_color() == "white"


def test_a_long_record_is_drawn_with_few_points_and_keeps_its_peaks(ax: Axes) -> None:
    forces = np.full(100_001, 0.5)
    forces[[0, -1]] = 0
    forces[30_000] = 1
    forces[70_001] = 0.9
    record = sw.Tabulated(times=np.linspace(0, 2, len(forces)), forces=forces)
    pictures.pulse(sw.Shock(profile=record, peak_force=FORCE, rise_time=1e-5), ax=ax)
    drawn = ax.lines[0].get_ydata()
    assert len(drawn) < 1000
    assert {FORCE, 0.9 * FORCE} <= set(drawn)
    areas = [float(area.get_paths()[0].vertices[:, 1].max()) for area in ax.collections]
    assert areas == pytest.approx([FORCE, FORCE])


def test_a_pulse_has_the_force_and_areas_of_the_shock(ax: Axes) -> None:
    shock = SHOCKS["ejection"]
    pictures.pulse(shock, ax=ax)
    x, y = ax.get_lines()[0].get_xydata().T  # type: ignore[union-attr]
    # multiplication and division by the rise time round
    force = FORCE * shock.profile.force(np.clip(x / shock.rise_time, 0, 3))
    assert y == pytest.approx(force, abs=1e-12 * FORCE)
    assert y.max() == FORCE
    # ticks are in the unit of the label
    assert ax.xaxis.get_major_formatter()(1.5e-5, 0) == "15"
    # a1 = 1/(1 + eta1), a2 = (n - 1)/(1 + eta2)
    assert key_of(ax) == ["rise, a₁ = 0.6667 F₀ t₀", "decay, a₂ = 1 F₀ t₀"]


def test_the_added_area_is_half_of_the_added_momentum(ax: Axes) -> None:
    outcome = section4("ejection")
    pictures.correction_area(SHOCKS["ejection"], outcome, ax=ax)
    x, y = np.asarray(ax.collections[0].get_paths()[0].vertices).T
    # the shoelace formula; the decay is a straight line, so that the area is exact except for rounding
    drawn = abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2
    assert 2 * drawn == pytest.approx(outcome.added_momentum, rel=1e-9)


def test_contact_forces_are_those_recorded(ax: Axes) -> None:
    result = recorded("ejection", "forces")
    pictures.contact_forces(result, ax=ax)
    # six of 45
    assert key_of(ax) == ["shock", *(f"contact {contact}" for contact in (0, 9, 18, 26, 35, 44))]
    x, y = line(ax, "contact 18")
    assert np.array_equal(x, result.recording.times)
    assert np.array_equal(y, result.recording.forces[:, 18])
    x, y = line(ax, "shock")
    assert (x[-1], y.max()) == (SHOCKS["ejection"].duration, FORCE)


@pytest.mark.parametrize("kind", ["shock", "striker"])
def test_forces_and_energies_of_a_finite_chain_are_those_recorded(ax: Axes, kind: str) -> None:
    result = in_finite_chain(kind)
    kept = result.recording
    assert kept is not None
    assert kept.forces is not None
    pictures.contact_forces(result, contacts=[0, 5, 9], ax=ax)
    assert key_of(ax) == [*["shock"] * (kind == "shock"), "contact 0", "contact 5", "contact 9"]
    assert np.array_equal(line(ax, "contact 9")[1], kept.forces[:, 9])
    other = pictures.figure()[1][0]
    pictures.balance(result, ax=other)
    label = "work of the shock" if kind == "shock" else "energy of the striker"
    x, y = line(other, label)
    assert (x[0] > 0) == (kind == "shock")
    assert y == pytest.approx(line(other, "total")[1][[-1, -1]], rel=1e-6)


def test_long_histories_keep_their_peaks_in_a_map(ax: Axes) -> None:
    interval = UNITS.time / 200
    result: Any = sw.simulate(SHOCKS["ejection"], CHAIN, contacts=range(5), record=["forces"], interval=interval)
    pictures.space_time(result, ax=ax)
    drawn = np.asarray(ax.collections[0].get_array())
    assert drawn.shape[1] < 500 < len(result.recording.times)
    assert np.array_equal(drawn.max(axis=1), result.recording.forces.max(axis=0))


@cache
def at_few_contacts() -> sw.Simulation:
    """A result of 60 granules before a wall that a striker hits, at three contacts, the last one with the wall."""
    chain = evolve(CHAIN, granules=60, end=sw.Wall(material="same"))
    return sw.simulate(sw.Impact(velocity=0.5), chain, contacts=[5, 30, 60], record=["forces"])


def test_a_map_of_few_contacts_shows_no_force_between_them(ax: Axes) -> None:
    result = at_few_contacts()
    pictures.chain_map(result, ax=ax)
    (mesh,) = ax.collections
    edges, rows = mesh.get_coordinates()[:, 0, 1], np.ma.getmaskarray(mesh.get_array()).all(axis=1)  # type: ignore[attr-defined]
    known = [(low, high) for low, high, empty in zip(edges, edges[1:], rows, strict=False) if not empty]
    assert [(low < contact < high) for (low, high), contact in zip(known, (5, 30, 60), strict=True)] == [True] * 3
    # a fortieth of the drawn part of the chain
    assert max(high - low for low, high in known) <= 55 / 40 + 1e-12
    assert edges[-1] == 60.5


def test_peaks_at_few_contacts_are_not_connected_and_are_those_of_the_document(ax: Axes) -> None:
    result = at_few_contacts()
    pictures.peak_forces(result, ax=ax)
    drawn = ax.get_lines()[0]
    document = result.to_dict()
    expected = [(peak["contact"], peak["peak_force"]) for peak in document["contacts"]]
    assert list(zip(*drawn.get_data(), strict=True)) == expected
    assert (drawn.get_linestyle(), drawn.get_marker()) == ("None", "o")
    wall = document["transmitted"]
    assert np.transpose(line(ax, "wall")).tolist() == [[wall["contact"], wall["peak_force"]]]


def test_equal_granules_have_a_picture_of_their_peaks_if_their_number_is_given(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["train"], evolve(CHAIN, granules=20))
    pictures.peak_forces(result, ax=ax)
    assert ax.get_lines()[0].get_xdata().tolist() == list(range(19))  # type: ignore[union-attr]
    with pytest.raises(sw.InvalidValueError, match=r"^chain\.granules: must be given \(got an endless chain"):
        pictures.peak_forces(sw.simulate(SHOCKS["train"], CHAIN), ax=ax)


@pytest.mark.parametrize("kind", ["shock", "striker"])
def test_borders_are_at_the_contacts_of_different_materials(ax: Axes, kind: str) -> None:
    segments = (sw.Segment(count=4), sw.Segment(count=3, material=sw.material("ptfe")))
    excitation = SHOCKS["train"] if kind == "shock" else sw.Impact(velocity=0.5)
    pictures.peak_forces(sw.simulate(excitation, evolve(CHAIN, granules=segments)), ax=ax)
    (border,) = (float(each.get_xdata()[0]) for each in ax.get_lines() if each.get_linestyle() == "--")  # type: ignore[index,arg-type]
    # between granules 3 and 4 of the chain, which a striker shifts by one
    assert border == (3 if kind == "shock" else 4)


def test_fronts_pass_through_the_measured_positions(ax: Axes) -> None:
    result = recorded("train", "forces")
    pictures.space_time(result, ax=ax)
    wave = result.waves[1]
    (x0, x1), (y0, y1) = line(ax, "front 2")
    assert (y1 - y0) / (x1 - x0) * 2 * CHAIN.radius == pytest.approx(wave.speed)
    assert x0 + (wave.contact - y0) * (x1 - x0) / (y1 - y0) == pytest.approx(wave.arrival_time)


def test_fronts_begin_behind_those_of_stronger_waves(ax: Axes) -> None:
    scene = sw.load_scenario(ROOT / "profiles" / "examples" / "hammer.yaml")
    pictures.space_time(sw.simulate(scene.shock, scene.chain, contacts=range(60), record=["forces"]), ax=ax)
    fronts = [each.get_xydata() for each in ax.get_lines() if str(each.get_label()).startswith("front")]
    assert len(fronts) > 2
    for before, front in itertools.pairwise(fronts):
        (time, contact), rounding = front[0], 1e-9  # type: ignore[index,misc]
        assert time >= np.interp(contact, before[:, 1], before[:, 0]) - rounding  # type: ignore[index]


@pytest.mark.parametrize("own", [True, False], ids=["own-axes", "new-figure"])
def test_titles_stand_above_the_mark_of_warnings_and_the_legend(own: bool) -> None:
    large = evolve(CHAIN, radius=4.75)
    ax = Figure().subplots() if own else pictures.figure()[1][0]
    pictures.train(sw.compare(SHOCKS["train"], large, rtol=1e-3), ax=ax)
    ax.set_title("title")
    ax.figure.draw_without_rendering()
    (mark,) = (text for text in ax.texts if text.get_text().startswith("!"))
    inner, above, title = (each.get_window_extent() for each in (ax, mark, ax.title))
    assert inner.y1 <= above.y0 < above.y1 <= title.y0
    legend = ax.get_legend()
    assert legend is not None
    assert own or legend.get_window_extent().y1 <= above.y0


@pytest.mark.parametrize("width", [2.0, 7.0])
def test_labels_of_a_logarithmic_axis_do_not_overlap(width: float) -> None:
    ax = Figure(figsize=(width, 2.5)).subplots()
    pictures.universal_curves({"triangle": curve("train")}, ax=ax)
    ax.figure.draw_without_rendering()
    low, high = ax.get_xlim()
    ticks = zip(ax.get_xticks(), ax.get_xticklabels(), strict=True)
    boxes = [label.get_window_extent() for tick, label in ticks if low <= tick <= high]
    assert len(boxes) > 1
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


def test_the_impulse_on_the_wall_ends_below_the_limit(ax: Axes) -> None:
    result = in_finite_chain("shock")
    pictures.wall_force(result, ax=ax)
    (right,) = (each for each in ax.figure.axes if each is not ax)
    impulse = right.get_lines()[0].get_ydata()
    assert impulse[-1] / right.get_ylim()[1] < 0.7  # type: ignore[index]


def test_the_impulse_on_a_loaded_wall_has_one_name(ax: Axes) -> None:
    loaded = evolve(in_finite_chain("shock").chain, precompression=2.0)
    result = sw.simulate(SHOCKS["train"], loaded, record=["forces"])
    pictures.wall_force(result, ax=ax)
    (right,) = (each for each in ax.figure.axes if each is not ax)
    assert right.get_ylabel().startswith("impulse beyond the static force")
    assert re.search(r"wall impulse .* beyond the static force$", str(result), re.MULTILINE)


def test_trains_have_the_forces_of_section_4_and_simulated_ones(ax: Axes) -> None:
    comparison = compared("train")
    waves = comparison.simulated.waves
    pictures.train(comparison, ax=ax)
    assert line(ax, "section 4")[1].tolist() == [wave.peak_force for wave in section4("train").waves]
    settled = [wave.peak_force for wave in waves if wave.error_estimate is not None]
    assert line(ax, "simulated")[1].tolist() == settled
    # a marker on the axis is not hidden
    assert not any(each.get_clip_on() for each in ax.get_lines() if each.get_marker() in ("o", "s"))
    assert set(line(ax, "shock")[1]) == {FORCE}


def test_the_approach_follows_the_passages_up_to_the_measurement(ax: Axes) -> None:
    result = sw.simulate(SHOCKS["ejection"], evolve(CHAIN, granules=12))
    pictures.approach(result, ax=ax)
    contacts, distances = line(ax, "simulation")
    assert contacts.tolist() == list(range(result.primary.contact))
    assert distances[2] == pytest.approx(abs(result.passage(2).peak_force / result.peak_force - 1))


@pytest.mark.parametrize("name", ["ejection", "train", "record", "tiny"])
def test_the_work_of_the_shock_is_the_energy_of_the_chain(ax: Axes, name: str) -> None:
    result = recorded(name, "energies")
    pictures.balance(result, ax=ax)
    energy = line(ax, "total")[1]
    assert np.array_equal(energy, result.recording.kinetic_energy + result.recording.contact_energy)
    # the energy error of a simulation with the default tolerance of 1e-6
    assert line(ax, "work of the shock")[1] == pytest.approx(energy[[-1, -1]], rel=1e-5)


def test_curves_have_the_values_of_simulation_and_section_4(ax: Axes) -> None:
    found = curve("train")
    pictures.universal_curves({"simulated": found}, mark=2.0, ax=ax)
    x, y = line(ax, "simulated")
    assert y == pytest.approx(found.amplification(x), rel=1e-12)
    assert (x[-1], ax.get_xscale()) == (found.longest_rise_time, "log")
    assert ax.get_legend_handles_labels()[1] == ["simulated", "section 4", "this shock"]
    expected = [point.section4_amplification for point in found.points]
    assert line(ax, "section 4")[1].tolist() == expected


def test_runs_are_connected_by_method_and_failed_runs_are_counted(ax: Axes) -> None:
    pictures.work_precision(RUNS, ax=ax)
    assert key_of(ax) == ["rk4", "formula (1 failed)", "other (1 failed)"]
    # an error of zero is drawn at the rounding error
    assert np.transpose(line(ax, "rk4")).tolist() == [[0.01, 1e-3], [1.0, 1e-16]]


REFUSED: dict[str, Any] = {
    "size: must be column, page or": lambda _: pictures.figure(size="huge"),
    r"file: must end in \.svg, \.png, \.pdf": lambda ax: pictures.save(ax.figure, "a.gif"),
    "nowhere/a.svg: cannot be written": lambda ax: pictures.save(ax.figure, "nowhere/a.svg"),
    r"figure: must be a Figure or Axes of matplotlib \(got 3\)": lambda _: pictures.save(3, "a.png"),  # type: ignore[arg-type]
    r"ax: must be Axes of matplotlib \(got 3; figure\(\) returns": lambda _: pictures.pulse(SHOCKS["train"], ax=3),  # type: ignore[arg-type]
    r"record: must have energies \(got field; simulate with record=\['energies'\]": lambda ax: pictures.balance(
        recorded("ejection", "field"), ax=ax
    ),
    r"contacts: must be recorded contacts, 0, 1, .*got 99": lambda ax: pictures.contact_forces(
        recorded("ejection", "forces"), contacts=[99], ax=ax
    ),
    r"result: must have a leading wave with a limit \(got forces at contacts alone; pictures\.peak_forces": lambda ax: (
        pictures.approach(in_finite_chain("striker"), ax=ax)  # type: ignore[arg-type]
    ),
}


@pytest.mark.parametrize("message", REFUSED, ids=lambda message: message[:24])
def test_invalid_sizes_files_and_data_are_refused(ax: Axes, message: str) -> None:
    with pytest.raises(sw.ShockwaveError, match=f"^{message}"):
        REFUSED[message](ax)


@pytest.mark.parametrize(
    ("draw", "kind"),
    [
        (pictures.pulse, "shock: must be Shock"),
        (pictures.train, "result: must be Comparison or Outcome or Simulation or Section4Outcome"),
        (pictures.design, "result: must be Design"),
        (pictures.universal_curves, "curves: must be Mapping"),
    ],
    ids=["shock", "scene", "design", "curves"],
)
def test_a_picture_of_something_else_is_an_error_that_names_what_is_wanted(draw: Any, kind: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=rf"^{kind}.* \(got 3\)"):
        draw(3)


def test_a_figure_gives_the_same_element_until_it_is_changed() -> None:
    figure, (ax,) = pictures.figure()
    ax.plot([0, 1])
    first, again = pictures.svg(figure), pictures.svg(figure)
    ax.set_title("two\nlines")
    assert first == again
    assert pictures.svg(figure) != again


def test_a_picture_of_results_with_warnings_is_marked() -> None:
    large = evolve(CHAIN, radius=4.75)  # metres for millimetres
    _, axes = pictures.figure(rows=3)
    pictures.train(sw.compare(SHOCKS["train"], large, rtol=1e-3), ax=axes[0])
    pictures.train(compared("ejection"), ax=axes[1])
    profile = sw.Tabulated([0.0, 1.0, 2.0], [0.0, 5.0, 3.0])  # ends with a jump
    pictures.universal_curves({"jump": UniversalCurve(profile, rtol=1e-2, longest=1.0)}, ax=axes[2])
    _, (dark,) = pictures.figure(dark=True)
    pictures.train(sw.compare(SHOCKS["train"], large, rtol=1e-3), ax=dark)
    assert min(contrast(text.get_color(), dark.get_facecolor()) for text in dark.texts) > 4.5
    marks = [[text.get_text() for text in ax.texts if text.get_text().startswith("!")] for ax in axes]
    assert marks == [["! 1 warning"], [], ["! 1 warning"]]


# ---------------------------------------------------------------- new figures, and settings of the user

#: Settings that make a picture illegible if it takes them.
HOSTILE = {"text.usetex": True, "font.size": 30, "axes.spines.left": False, "axes.spines.bottom": False}
HOSTILE |= {"axes.prop_cycle": "cycler('color', ['white'])", "lines.marker": "D", "lines.linestyle": ":"}


@pytest.fixture
def pyplot() -> Iterator[Any]:
    from matplotlib import pyplot

    pyplot.close("all")  # pages that ran before leave figures open
    yield pyplot
    pyplot.close("all")


def linear_rgb(colour: Any) -> np.ndarray:
    parts = np.array(to_rgb(colour))
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def luminance(colour: Any) -> float:
    return float(np.dot((0.2126, 0.7152, 0.0722), linear_rgb(colour)))


def contrast(one: Any, other: Any) -> float:
    """Contrast of two colours as defined by WCAG 2, from 1 to 21."""
    low, high = sorted(map(luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


def marks_of(ax: Axes) -> list[Any]:
    """Colours of all that must be visible: texts, and lines that are not transparent."""
    legend = ax.get_legend()
    texts = [*ax.texts, ax.xaxis.label, ax.yaxis.label, *(legend.get_texts() if legend else ())]
    ticks = [label for label in (*ax.get_xticklabels(), *ax.get_yticklabels()) if label.get_text()]
    lines = [each for each in ax.get_lines() if each.get_alpha() is None and each.get_linestyle() != "None"]
    return [each.get_color() for each in (*texts, *ticks, *lines)]


@pytest.mark.parametrize("own", [True, False], ids=["own-axes", "new-figure"])
@pytest.mark.parametrize("picture", PICTURES)
def test_a_picture_is_legible_on_a_dark_background(picture: str, own: bool, pyplot: Any) -> None:
    with pyplot.style.context("dark_background"):
        ax = PICTURES[picture](pyplot.subplots()[1] if own else None, "ejection")
        assert pyplot.get_fignums() == [ax.figure.number]  # without axes a new one
        # colours of maps are separated by their outlines
        if picture != "space_time":
            assert min(contrast(colour, ax.get_facecolor()) for colour in marks_of(ax)) > 3


@pytest.mark.parametrize("picture", PICTURES)
def test_hostile_settings_do_not_reach_a_picture(picture: str, pyplot: Any) -> None:
    with matplotlib.rc_context(HOSTILE):
        ax = PICTURES[picture](None, "ejection")
        user = PICTURES[picture](Figure().subplots(), "ejection")
    # no LaTeX is needed
    assert inside(ax.figure)
    assert {each.get_usetex() for each in user.findobj(Text) if each.get_text()} <= {False}
    for each, drawn in zip(ax.get_lines(), user.get_lines(), strict=True):
        assert (each.get_marker(), each.get_linestyle(), each.get_color()) == (
            drawn.get_marker(),
            drawn.get_linestyle(),
            drawn.get_color(),
        )


def test_the_style_can_be_used_for_other_pictures(pyplot: Any) -> None:
    for dark in (False, True):
        _, (ours,) = pictures.figure(dark=dark)
        with matplotlib.rc_context(HOSTILE), pyplot.style.context(["default", pictures.style(dark)]):
            _, ax = pyplot.subplots()
        for each in (ours, ax):
            each.plot([0, 1], label="a")
            each.set(xlabel="x", title="title")
        for name in ("facecolor", "ylim"):
            assert getattr(ours, f"get_{name}")() == getattr(ax, f"get_{name}")()
        assert ours.xaxis.label.get_color() == ax.xaxis.label.get_color()
        assert ours.xaxis.label.get_size() == ax.xaxis.label.get_size()
        assert luminance(ax.get_facecolor()) < 0.05 if dark else ax.get_facecolor() == (1, 1, 1, 1)


#: Machado, Oliveira & Fernandes, IEEE Trans. Vis. Comput. Graph. 15, 1291 (2009), table of severity 1, linear RGB.
BLIND = {
    "protanopia": [(0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)],
    "deuteranopia": [(0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.01182, 0.04294, 0.968881)],
    "tritanopia": [(1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.3039)],
}
XYZ = np.array([(0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505)])


def lab(colour: Any, seen: Any = None) -> np.ndarray:
    """CIELAB coordinates of a colour, as seen by readers with this matrix."""
    linear = linear_rgb(colour)
    shown = linear if seen is None else np.clip(np.array(seen) @ linear, 0, 1)
    x, y, z = np.cbrt(np.maximum(XYZ @ shown / XYZ.sum(axis=1), 1e-6))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("kind", BLIND)
def test_colours_of_methods_are_distinct_for_colour_blind_readers(kind: str) -> None:
    pairs = itertools.combinations([*pictures.METHODS.values(), "black", "white"], 2)
    # a distance of 2.3 is just noticeable between large areas
    assert min(float(np.linalg.norm(lab(one, BLIND[kind]) - lab(other, BLIND[kind]))) for one, other in pairs) > 20
    assert min(contrast(colour, paper) for colour in pictures.METHODS.values() for paper in ("black", "white")) > 3


@pytest.mark.parametrize("kind", [None, *BLIND])
def test_colours_of_lines_are_distinct_and_visible(kind: str | None) -> None:
    seen = [lab(colour, BLIND[kind] if kind else None) for colour in COLOURS]
    assert min(float(np.linalg.norm(one - other)) for one, other in itertools.combinations(seen, 2)) > 10
    assert min(contrast(colour, paper) for colour in COLOURS for paper in ("black", "white")) > 3


@pytest.mark.parametrize("picture", ["approach", "amplification", "train"])
def test_simulated_numbers_have_the_same_colour_in_every_picture(picture: str, ax: Axes) -> None:
    PICTURES[picture](ax, "ejection")
    (drawn,) = (each for each in ax.get_lines() if each.get_label() in ("simulation", "simulated", "ejection"))
    assert drawn.get_color() == pictures.METHODS["simulation"]


def test_ticks_of_numbers_with_and_without_a_unit_are_alike() -> None:
    figure, axes = pictures.figure(rows=3)
    for ax, scale, label in zip(axes, ("linear", "linear", "log"), (("force", "N"), "ratio", "ratio"), strict=True):
        ax.set(xscale=scale, xlim=(0.0, 2.0) if scale == "linear" else (1e-3, 1e3))
        label_axis(ax, "x", label)
    figure.canvas.draw()
    force, linear, log = ([label.get_text() for label in ax.get_xticklabels()] for ax in axes)
    assert linear == force
    assert not any(text.endswith(".0") for text in linear)
    assert {"0.01", "1", "100"} <= set(log)


@pytest.mark.parametrize("ends", [(370.0, 1600.0), (900.0, 1300.0), (3.0, 90.0)])
def test_a_logarithmic_axis_has_three_labelled_ticks_or_more(ends: tuple[float, float]) -> None:
    figure, (ax,) = pictures.figure()
    ax.set(xscale="log", xlim=ends)
    label_axis(ax, "x", ("force", "N"))
    figure.canvas.draw()
    ticks = [tick for tick in ax.get_xticks() if ends[0] <= tick <= ends[1]]
    assert 3 <= len(ticks) <= 8
