"""Pictures of the documentation are those that its script draws."""

import importlib.util
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shockwave import pictures
from support.drawn_svg import distance, shown_in

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FILES = [file.relative_to(DOCS) for file in DOCS.glob("*/*.svg")]
# the logo is no picture of results
STORED = sorted(str(file.with_suffix("")) for file in FILES if file.parts[0] != "_static")
# Largest distance of drawn values, in units of the frame; other versions of matplotlib have another layout.
NEAR = 0.02


@pytest.fixture(scope="module")
def script() -> Iterator[Any]:
    file = ROOT / "research" / "draw" / "draw_pictures.py"
    path = sys.path[:]
    spec = importlib.util.spec_from_file_location("draw_pictures", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["draw_pictures"] = module
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = path


@cache
def text_of_pages() -> str:
    return "\n".join(file.read_text(encoding="utf-8") for file in [ROOT / "README.md", *DOCS.glob("*.md")])


@pytest.mark.parametrize("name", STORED)
def test_a_picture_is_shown_on_a_page(name: str) -> None:
    assert re.search(rf"[(/]{name}\.svg", text_of_pages())


def test_the_script_draws_every_picture(script: Any) -> None:
    assert sorted(script.PICTURES) == STORED


@pytest.mark.slow
@pytest.mark.parametrize("name", STORED)
def test_a_picture_is_the_one_that_the_script_draws(name: str, script: Any, tmp_path: Path) -> None:
    pictures.save(script.PICTURES[name](), tmp_path / "drawn.svg")
    stored, drawn = shown_in(DOCS / f"{name}.svg"), shown_in(tmp_path / "drawn.svg")
    assert len(stored) == len(drawn) > 0
    for one, other in zip(stored, drawn, strict=True):
        assert one[:2] == other[:2]
        assert [len(kind) for kind in one[2:]] == [len(kind) for kind in other[2:]]
        for here, there in zip(one.curves, other.curves, strict=True):
            assert max(distance(here, there), distance(there, here)) < NEAR
        for here, there in zip(one.marks, other.marks, strict=True):
            assert here.shape == there.shape
            assert np.abs(here - there).max(initial=0) < NEAR
        for here, there in zip(one.images, other.images, strict=True):
            assert np.abs(here - there).mean() < NEAR
