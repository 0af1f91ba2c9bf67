"""Files of a known blow in many styles: read with their keys, refused without them, never misread."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from record_styles import DURATION, PEAK, RISE, styles
from shockwave.errors import ShockwaveError

pytestmark = pytest.mark.numerical

STYLES = styles()
#: Without these the file is read all the same, with a note: there is no header that could state the unit.
NOTED = {("column-numbers", "time_unit")}
SUBSETS = [
    (name, left_out)
    for name, style in STYLES.items()
    for size in range(1, len(style.keys) + 1)
    for left_out in combinations(style.keys, size)
]


def load(folder: Path, name: str, keys: dict[str, Any]) -> sw.Shock:
    """The shock of a scenario that states ``keys``."""
    (folder / "pulse.csv").write_bytes(STYLES[name].content)
    document = {
        "chain": {"material": "copper", "diameter": "10 mm"},
        "shock": {"profile": "tabulated", "parameters": {"file": "pulse.csv", **keys}},
    }
    (folder / "scenario.yaml").write_text(json.dumps(document))
    return sw.load_scenario(folder / "scenario.yaml").shock


@pytest.mark.parametrize("name", STYLES)
def test_a_record_is_read_with_its_keys(tmp_path: Path, name: str) -> None:
    style, shock = STYLES[name], load(tmp_path, name, STYLES[name].keys)
    impulse = shock.profile.areas().total * shock.peak_force * shock.rise_time
    assert shock.peak_force == pytest.approx(PEAK, rel=style.spread)
    # the noise of 240 samples sums up to 60 uN s, and the baseline is uncertain by 0.5 N in 160 us
    assert impulse == pytest.approx(style.impulse, rel=1e-3 if style.spread == 1e-3 else 1e-2)
    # samples before the force exceeds the noise are quiet, and the highest may be a few samples off
    assert shock.rise_time == pytest.approx(RISE, abs=1e-9 if style.spread == 1e-3 else 9e-6)
    if name != "pulling":
        assert shock.duration == pytest.approx(DURATION, abs=2e-6 if style.spread == 1e-3 else 25e-6)


@pytest.mark.parametrize(
    ("name", "left_out"), SUBSETS, ids=lambda part: part if isinstance(part, str) else "-".join(part)
)
def test_a_record_without_a_key_is_refused_by_a_sentence_that_names_it(
    tmp_path: Path, name: str, left_out: tuple[str, ...]
) -> None:
    if left_out == ("time_unit",) and (name, "time_unit") in NOTED:
        notes = load(tmp_path, name, {"columns": STYLES[name].keys["columns"]}).profile.notes
        assert any("seconds are assumed" in note and "time_unit" in note for note in notes)
        return
    keys = {key: value for key, value in STYLES[name].keys.items() if key not in left_out}
    with pytest.raises(ShockwaveError) as caught:
        load(tmp_path, name, keys)
    assert any(key in str(caught.value) for key in left_out)
    assert "pulse.csv:" in str(caught.value) or "scenario.yaml:1:" in str(caught.value)
