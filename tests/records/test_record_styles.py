"""Files of known blows in many styles: read as their header states, or refused with the keys that make them right."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

import shockwave as sw
from shockwave.base.errors import ShockwaveError
from support.record_styles import IMPULSE, PEAK, RISE, Style, styles

STYLES = styles()
#: A key and the value that a message proposes, as in a scenario.
PROPOSAL = re.compile(r"\b([a-z]+(?:_[a-z]+)?): (\[[^]]*\]|'[^']*'|-?[\w./*-]+(?: [mun]?s\b)?)")
# Keys whose values messages propose.
PROPOSED = {
    *("baseline", "crop", "negative", "skip_rows", "columns"),
    *("time_unit", "unit", "interval", "decimal", "encoding"),
}
# Rounds of corrections after which a user would give up.
ROUNDS = 6


def load(folder: Path, content: bytes, keys: dict[str, Any]) -> sw.Shock:
    """The shock of a scenario that states ``keys``."""
    (folder / "pulse.csv").write_bytes(content)
    document = {
        "chain": {"material": "copper", "diameter": "10 mm"},
        "shock": {"profile": "tabulated", "parameters": {"file": "pulse.csv", **keys}},
    }
    (folder / "scenario.yaml").write_text(json.dumps(document))
    return sw.load_scenario(folder / "scenario.yaml").shock


def answer(folder: Path, content: bytes, keys: dict[str, Any]) -> tuple[sw.Shock | None, str]:
    """The shock, if the file is read, and the error or warnings."""
    try:
        shock = load(folder, content, keys)
    except ShockwaveError as error:
        return None, str(error)
    return shock, "\n".join(shock.profile.alarms)


def proposals(message: str, known: dict[str, Any]) -> dict[str, Any]:
    """Keys that a message proposes, or names if their values are ``known``."""
    keys = {key: yaml.safe_load(value) for key, value in PROPOSAL.findall(message) if value != "must"}
    named = {key: value for key, value in known.items() if re.search(rf"\b{key}\b", message)}
    return {key: value for key, value in keys.items() if key in PROPOSED} | named


def is_right(shock: sw.Shock) -> bool:
    impulse = shock.profile.total_area * shock.peak_force * shock.rise_time
    return (shock.peak_force, shock.rise_time, impulse) == pytest.approx((PEAK, RISE, IMPULSE), rel=0.01)


@pytest.mark.parametrize("name", STYLES)
def test_a_record_is_right_or_its_messages_lead_to_the_keys_that_make_it_right(tmp_path: Path, name: str) -> None:
    style: Style = STYLES[name]
    content, keys, remedy = style.content, dict[str, Any](), style.remedy
    for _ in range(ROUNDS):
        shock, message = answer(tmp_path, content, keys)
        new = {key: value for key, value in proposals(message, style.keys).items() if keys.get(key) != value}
        if remedy and remedy in message:
            content, remedy = style.mended, ""
        elif shock is not None and not new:
            break
        else:
            assert new, message
            keys |= new
    assert shock is not None, message
    assert not remedy, message
    if style.lost:
        assert style.lost in message
    else:
        assert is_right(shock), (keys, message)
