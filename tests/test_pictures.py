"""Pictures: nothing is cut, axes tell their units, files are the same to the byte on every run."""

from __future__ import annotations

import io
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

import shockwave as sw
from drawings import ERRORS, REGIMES, ROOT, RUNS, SHOCKS, N, X, compared, recorded
from scenes import CHAIN
from shockwave import pictures

PICTURES: dict[str, Any] = {
    "pulse": lambda ax, name: pictures.pulse(ax, SHOCKS[name]),
    "conditions": lambda ax, name: pictures.conditions(ax, SHOCKS[name]),
    "contact_forces": lambda ax, name: pictures.contact_forces(ax, recorded(name, "forces")),
    "space_time": lambda ax, name: pictures.space_time(ax, recorded(name, "forces")),
    "train": lambda ax, name: pictures.train(ax, compared(name)),
    "approach": lambda ax, name: pictures.approach(ax, compared(name).simulated),
    "energy": lambda ax, name: pictures.books(ax, recorded(name, "energies")),
    "momentum": lambda ax, name: pictures.books(ax, recorded(name, "field"), of="momentum"),
    "amplification": lambda ax, name: pictures.amplification(
        ax, SHOCKS[name].profile, sw.Predictor(), CHAIN, rise_times=np.geomspace(0.3, 3, 5)
    ),
}
OTHERS: dict[str, Any] = {
    "correction_area": lambda ax: pictures.correction_area(ax, SHOCKS["ejection"], compared("ejection").predicted),
    "work_precision": lambda ax: pictures.work_precision(ax, RUNS),
    "trust_map": lambda ax: pictures.trust_map(ax, X, N, ERRORS, REGIMES),
}
ALL: dict[str, Any] = {
    **{
        f"{picture} of {name}": (lambda ax, d=draw, n=name: d(ax, n))
        for picture, draw in PICTURES.items()
        for name in SHOCKS
        if (picture, name) != ("amplification", "long decay")
    },
    **OTHERS,
}


@pytest.fixture
def ax() -> Axes:
    return pictures.figure()[1][0]


# ---------------------------------------------------------------- all of them


PAGES = [name for name in ALL if name.endswith("ejection") or name in OTHERS]
COLUMNS = [pytest.param(name, "column", marks=[pytest.mark.slow] * (name not in PAGES)) for name in ALL]


@pytest.mark.parametrize(
    ("name", "size"), [*COLUMNS, *(pytest.param(name, "page", marks=pytest.mark.slow) for name in PAGES)]
)
def test_nothing_leaves_the_figure(name: str, size: str) -> None:
    figure, (ax,) = pictures.figure(size=size)
    assert ALL[name](ax) is ax
    figure.draw_without_rendering()
    around = ax.get_tightbbox()
    assert around is not None
    # a pixel of slack for the rounding of letters
    assert around.x0 > -1
    assert around.y0 > -1
    assert around.x1 < figure.bbox.width + 1
    assert around.y1 < figure.bbox.height + 1
    # the picture itself keeps a third of the figure at least
    assert ax.get_window_extent().width > figure.bbox.width / 3
    assert ax.get_window_extent().height > figure.bbox.height / 3


UNITS_OF_AXES = {
    "pulse": ("time (µs)", "force (N)"),
    "contact_forces": ("time (µs)", "contact force (N)"),
    "space_time": ("time (µs)", "contact"),
    "train": ("wave", "peak force (N)"),
    "approach": ("contact", "relative distance to the limit"),
    "energy": ("time (µs)", "energy (µJ)"),
    "momentum": ("time (µs)", "momentum (mN s)"),
    "amplification": ("rise time over characteristic time, $t_0/T_0$", "amplification"),
    "conditions": ("margin over the sum of both sides", ""),
}


@pytest.mark.parametrize("picture", UNITS_OF_AXES)
def test_axes_tell_their_units(ax: Axes, picture: str) -> None:
    PICTURES[picture](ax, "ejection")
    assert (ax.get_xlabel(), ax.get_ylabel()) == UNITS_OF_AXES[picture]


@pytest.mark.parametrize(
    ("picture", "told"),
    [
        ("correction_area", ("time (µs)", "force (N)")),
        ("work_precision", ("time (ms)", "relative error")),
        ("trust_map", ("duration over characteristic time, $n t_0/T_0$", "duration over rise time, $n$")),
    ],
)
def test_other_axes_tell_their_units(ax: Axes, picture: str, told: tuple[str, str]) -> None:
    OTHERS[picture](ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == told


def test_ticks_are_written_in_the_unit_of_the_label(ax: Axes) -> None:
    pictures.pulse(ax, sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=2e3, rise_time=1e-6))
    formatter = ax.yaxis.get_major_formatter()
    assert ax.get_ylabel() == "force (kN)"
    assert formatter(1500.0, 0) == "1.5"


# ---------------------------------------------------------------- what is written


def test_svg_is_the_same_twice() -> None:
    def drawn() -> str:
        figure, (left, right) = pictures.figure(1, 2)
        pictures.train(left, compared("train"))
        pictures.trust_map(right, X, N, ERRORS, REGIMES)
        return pictures.svg(figure)

    assert drawn() == drawn()


def test_names_in_an_svg_begin_with_its_own() -> None:
    figure, (ax,) = pictures.figure()
    pictures.pulse(ax, SHOCKS["ejection"])
    root = ET.fromstring(pictures.svg(figure, "one", 'a "sharp" <shock>'))
    named = {element.get("id") for element in root.iter() if element.get("id")}
    assert named
    assert all(name is not None and name.startswith("one-") for name in named)
    href = "{http://www.w3.org/1999/xlink}href"
    assert {element.get(href, "").removeprefix("#") for element in root.iter() if element.get(href)} <= named
    assert root.get("aria-label") == 'a "sharp" <shock>'


@pytest.mark.parametrize(("kind", "head"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_saved_by_the_ending(tmp_path: Path, kind: str, head: bytes) -> None:
    figure, (ax,) = pictures.figure()
    pictures.pulse(ax, SHOCKS["ejection"])
    for name in ("one", "two"):
        pictures.save(figure, tmp_path / f"{name}.{kind}")
    first, second = ((tmp_path / f"{name}.{kind}").read_bytes() for name in ("one", "two"))
    assert first.startswith(head)
    assert first == second
    # two files of one second would agree even if they were dated
    assert b"CreationDate" not in first
    assert b"dc:date" not in first


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: pictures.figure(size="huge"), r"^size: must be column, page or"),
        (lambda: pictures.save(pictures.figure()[0], "a.gif"), r"^file: must end in \.svg, \.png, \.pdf"),
        (lambda: pictures.svg(pictures.figure()[0], 'a"b'), r"^name: must be a letter"),
    ],
    ids=["size", "ending", "name"],
)
def test_wrong_sizes_and_names_are_refused(call: Any, told: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=told):
        call()


def test_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(sw.FileAccessError, match="cannot be written"):
        pictures.save(pictures.figure()[0], tmp_path / "nowhere" / "a.svg")


# ---------------------------------------------------------------- matplotlib


def test_without_matplotlib_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(sw.UsageError) as caught:
        pictures.figure()
    assert str(caught.value) == "pictures need matplotlib: pip install 'granular-shockwave[plot]'"


def test_pictures_load_no_matplotlib_before_one_is_drawn() -> None:
    program = "import sys, shockwave.pictures; assert not {m for m in sys.modules if m.startswith('matplotlib')}"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


def test_pictures_of_the_documentation_are_small() -> None:
    sizes = {file.name: file.stat().st_size for file in (ROOT / "docs" / "pictures").glob("*.svg")}
    assert len(sizes) == 11
    assert max(sizes.values()) < 150_000
    assert sum(sizes.values()) < 1_000_000


def test_png_shows_something() -> None:
    figure, (ax,) = pictures.figure()
    pictures.pulse(ax, SHOCKS["ejection"])
    written = io.BytesIO()
    figure.savefig(written, format="rgba", dpi=50)
    assert len(set(written.getvalue())) > 50
