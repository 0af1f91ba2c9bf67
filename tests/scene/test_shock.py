"""The shock: its profile, peak force and rise time, with those of a record as defaults."""

from __future__ import annotations

import math
from typing import Any

import pytest

import shockwave as sw

SCALES = {"peak_force": 1.0, "rise_time": 1.0}


@pytest.mark.parametrize("value", [0, math.nan, math.inf, True, [1.0]], ids=str)
@pytest.mark.parametrize(("name", "unit"), [("peak_force", "N"), ("rise_time", "s")])
def test_a_wrong_value_is_refused_with_its_rule(name: str, unit: str, value: object) -> None:
    with pytest.raises(sw.InvalidValueError) as caught:
        sw.Shock(profile=sw.Triangular(duration_ratio=2), **{**SCALES, name: value})
    assert str(caught.value) == f"{name}: must be > 0 {unit} (got {value!r})"


@pytest.mark.parametrize("name", SCALES)
def test_a_shape_that_is_not_a_record_needs_peak_force_and_rise_time(name: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=rf"^{name}: must be given"):
        sw.Shock(profile=sw.Triangular(duration_ratio=2), **{**SCALES, name: None})


@pytest.mark.parametrize(
    ("values", "expected"),
    [({}, (80.0, 2e-6)), ({"peak_force": 7.0}, (7.0, 2e-6)), ({"rise_time": 3e-6}, (80.0, 3e-6))],
    ids=["record", "peak-force", "rise-time"],
)
def test_a_record_supplies_missing_values(values: dict[str, float], expected: tuple[float, float]) -> None:
    shock = sw.Shock(profile=sw.Tabulated([0.0, 2e-6, 5e-6], [0.0, 80.0, 0.0]), **values)
    assert (shock.peak_force, shock.rise_time) == expected
    assert shock.duration == pytest.approx(2.5 * expected[1], rel=1e-15)


@pytest.mark.parametrize("profile", ["power-law", sw.PowerLaw], ids=["name", "class"])
def test_an_object_that_is_not_a_profile_is_refused(profile: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match="profile"):
        sw.Shock(profile=profile, **SCALES)
