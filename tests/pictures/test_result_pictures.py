"""Pictures that results draw of themselves; the distribution of an uncertain force."""

from functools import cache
from typing import Any

import pytest
from attrs import evolve
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

import shockwave as sw
from shockwave import pictures
from shockwave.base.result import Result
from shockwave.base.text import percent
from support.figures import inside, key_of
from support.scenes import CHAIN, triangle

pytestmark = pytest.mark.usefixtures("few_draws")

WALLED = evolve(CHAIN, granules=4, end=sw.Wall(material="same"))
SHOCK = triangle(0.5)


@cache
def uncertain(limit: float | None = None, chain: sw.Chain = CHAIN) -> sw.Uncertainty:
    return sw.uncertainty(SHOCK, chain, {"shock.peak_force": "10 %"}, draws=64, rtol=1e-2, limit=limit)


@cache
def designed(least: str | None = None, **varied: Any) -> sw.Design:
    vary = {"chain.diameter": ("5 mm", "15 mm")} if least else "chain.diameter"
    between = None if least else ("5 mm", "15 mm")
    target = "transmitted.peak_force <= 40 N" if least else "peak_force = 40 N"
    return sw.design(
        SHOCK, WALLED if least else CHAIN, vary=vary, between=between, target=target, least=least, **varied
    )


def ranked() -> sw.Design:
    return sw.design(SHOCK, CHAIN, vary="chain.material", target="peak_force <= 40 N", among=["ptfe", "lead"])


#: A result of each kind, with labels of its axes.
RESULTS: dict[str, tuple[Any, tuple[str, str]]] = {
    "outcome": (lambda: sw.predict(SHOCK, CHAIN), ("wave", "peak force (N)")),
    "section 4": (lambda: sw.predict(SHOCK, CHAIN).section4, ("wave", "peak force (N)")),
    "outcome on a wall": (lambda: sw.predict(SHOCK, WALLED), ("contact", "greatest force (N)")),
    "simulation": (lambda: sw.simulate(SHOCK, CHAIN), ("wave", "peak force (N)")),
    "finite chain": (lambda: sw.simulate(SHOCK, WALLED), ("contact", "greatest force (N)")),
    "histories": (lambda: sw.simulate(SHOCK, WALLED, record=["forces"]), ("time (µs)", "contact force (N)")),
    "recording": (lambda: sw.simulate(SHOCK, WALLED, record=["forces"]).recording, ("time (µs)", "contact force (N)")),
    "comparison": (lambda: sw.compare(SHOCK, CHAIN), ("wave", "peak force (N)")),
    "spectrum": (
        lambda: sw.simulate(SHOCK, WALLED).spectrum(mass=1.0, low=1e3, high=1e4),
        ("natural frequency (kHz)", "greatest acceleration (m/s²)"),
    ),
    "curve": (
        lambda: sw.UniversalCurve(SHOCK.profile, rtol=1e-2),
        ("rise time / characteristic time, t₀/T₀", "amplification"),
    ),
    "design": (designed, ("diameter (mm)", "peak force (N)")),
    "ranking": (ranked, ("peak force (N)", "")),
    "lightest": (lambda: designed("chain.mass", points=3), ("chain mass (kg)", "wall force (N)")),
    "uncertainty": (uncertain, ("peak force (N)", "scenes")),
}


@pytest.fixture
def ax() -> Axes:
    return pictures.figure()[1][0]


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_draws_itself(name: str, ax: Axes) -> None:
    make, labels = RESULTS[name]
    assert make().plot(ax=ax) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels
    assert inside(ax.figure)


def test_every_kind_of_result_has_a_picture() -> None:
    kinds = {getattr(sw, name) for name in sw.__all__ if isinstance(getattr(sw, name), type)}
    undrawn = {kind.__name__ for kind in kinds if issubclass(kind, Result) and not kind._picture}
    assert undrawn == {"SweepReport"}


def test_a_result_without_a_picture_is_refused() -> None:
    class Plain(Result):
        """A result without tables and pictures."""

    with pytest.raises(sw.UsageError, match=r"^Plain has no picture$"):
        Plain().plot()


def test_without_axes_a_result_is_drawn_on_a_new_figure() -> None:
    ax = sw.simulate(SHOCK, CHAIN).plot()
    assert pyplot.get_fignums() == [ax.figure.number]  # type: ignore[union-attr]
    assert pictures.svg(ax) == pictures.svg(ax.figure)  # type: ignore[arg-type]
    pyplot.close("all")


def test_a_picture_of_all_waves_is_marked_with_their_warnings(ax: Axes) -> None:
    slow = evolve(SHOCK, profile=sw.Triangular(duration_ratio=3), rise_time=4e-4)
    outcome = sw.predict(slow, CHAIN)
    assert outcome.warnings == ()  # its first number has none
    outcome.plot(ax=ax)
    assert [text.get_text() for text in ax.texts] == ["! 1 warning"]


def test_a_limit_is_drawn_at_its_force(ax: Axes) -> None:
    sw.simulate(SHOCK, WALLED, limit="60 N").plot(ax=ax)
    (drawn,) = (each for each in ax.get_lines() if each.get_label() == "limit")
    assert set(drawn.get_ydata()) == {60.0}  # type: ignore[arg-type]
    assert ax.get_ylim()[1] > 60


def test_a_distribution_has_the_draws_and_the_probability_of_the_limit(ax: Axes) -> None:
    limit = uncertain().peak_force.quantiles[0.95].value  # type: ignore[union-attr]
    result = uncertain(limit)
    pictures.distribution(result, ax=ax)
    bars = [each for each in ax.patches if isinstance(each, Rectangle)]
    counts, lefts = [each.get_height() for each in bars], [each.get_x() for each in bars]
    assert sum(counts) >= result.draws
    assert min(lefts) == pytest.approx(result.outputs["peak_force"].min())
    assert "limit, reached with probability" in key_of(ax)[-1]
    assert result.exceedance is not None
    assert f"probability {percent(result.exceedance.probability)}" in key_of(ax)[-1]


def test_a_distribution_of_another_quantity_has_no_limit(ax: Axes) -> None:
    pictures.distribution(uncertain(60.0), "amplification", ax=ax)
    assert ax.get_xlabel() == "amplification"
    assert not any("limit" in text for text in key_of(ax))
    with pytest.raises(sw.UnknownNameError, match=r"quantity.*amplification"):
        pictures.distribution(uncertain(60.0), "amplifcation", ax=ax)


@pytest.mark.parametrize(("until", "last"), [(None, 1.0), (5e-3, 0.3)], ids=["as long as the motion", "ten times"])
def test_axes_of_time_end_soon_after_the_last_force(until: float | None, last: float) -> None:
    result = sw.simulate(SHOCK, WALLED, record=["forces"], sensors=["wall"], until=until)
    for draw in (pictures.contact_forces, pictures.wall_force, pictures.sensors, pictures.chain_map):
        ax = draw(result)
        end = ax.get_xlim()[1]
        pyplot.close(ax.figure)
        force = result.recording.wall_force[result.recording.times > end]
        assert end <= last * result.recording.times[-1]
        assert force.max(initial=0.0) < 0.02 * result.transmitted.peak_force
