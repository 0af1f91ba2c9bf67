"""The shock: its profile, by itself or by its name, peak force and rise time, with those of a record as defaults."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml

import shockwave as sw

SCALES = {"peak_force": 1.0, "rise_time": 1.0}


@pytest.mark.parametrize(
    ("value", "rule"),
    [(0, "> 0 {}"), (math.nan, "> 0 {}"), (math.inf, "finite"), *((each, "a {}") for each in (True, [1.0], 1j, {}))],
    ids=str,
)
@pytest.mark.parametrize(
    ("name", "unit", "kind"),
    [("peak_force", "N", "force, such as '100 N'"), ("rise_time", "s", "time, such as '15 us'")],
)
def test_a_wrong_value_is_refused_with_its_rule(name: str, unit: str, kind: str, value: object, rule: str) -> None:
    with pytest.raises(sw.InvalidValueError) as caught:
        sw.Shock(profile=sw.Triangular(duration_ratio=2), **{**SCALES, name: value})
    expected = rule.format(unit if ">" in rule else kind)
    assert str(caught.value) == f"{name}: must be {expected} (got {value!r})"


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


CHAIN = {"material": "ptfe", "diameter": "9.5 mm"}
#: The keys of blocks ``shock``.
BLOCKS: dict[str, dict[str, Any]] = {
    "ratio": {"profile": "triangular", "peak_force": "20 N", "rise_time": "10 us", "duration_ratio": 4},
    "duration and ratio": {"profile": "triangular", "peak_force": 20, "duration": "40 us", "duration_ratio": 4},
    "duration and rise": {"profile": "Triangular", "peak_force": 20, "duration": "40 us", "rise_time": "10 us"},
    "parameters": {
        "profile": "power-law",
        "peak_force": "20 N",
        "rise_time": "10 us",
        "duration_ratio": 4,
        "parameters": {"rise_exponent": 1, "decay_exponent": "200 %"},
    },
    "record": {"profile": "tabulated", "parameters": {"times": [0, "1 us", 3e-6], "forces": [0, 5, 0]}},
    "record of a duration": {
        "profile": "tabulated",
        "duration": "30 us",
        "parameters": {"file": "pulse.csv", "sign": -1},
    },
}


@pytest.mark.parametrize("name", BLOCKS)
def test_a_shock_takes_the_keys_of_the_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pulse.csv").write_text("time [us],force [N]\n0,0\n1,-5\n3,0\n", encoding="utf-8")
    Path("scene.yaml").write_text(yaml.safe_dump({"shock": BLOCKS[name], "chain": CHAIN}), encoding="utf-8")
    assert sw.Shock(**BLOCKS[name]) == sw.load_scenario("scene.yaml").shock


@pytest.mark.usefixtures("sample_plugins")
def test_a_shock_takes_the_name_of_a_profile_of_a_plugin() -> None:
    shock = sw.Shock(profile="trapezoid", duration="1 ms", peak_force=2, parameters={"rise_fraction": "20 %"})
    assert (shock.rise_time, shock.duration) == pytest.approx((2e-4, 1e-3))
    with pytest.raises(sw.InvalidValueError, match=r"^parameters\.rise_frction: .*did you mean 'rise_fraction'"):
        sw.Shock(profile="trapezoid", duration=1, parameters={"rise_frction": 1})


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"profile": "triangularr", "duration_ratio": 4}, "did you mean 'triangular'"),
        ({"profile": "triangular"}, "^duration_ratio: must be given .*or give duration"),
        ({"profile": "triangular", "duration_ratio": 1}, "^duration_ratio: must be > 1"),
        ({"profile": "exponential", "duration_ratio": 4}, "^parameters.rise_rate: must be given"),
        (
            {"profile": "tabulated", "parameters": {"file": "x.csv", "sing": -1}},
            "^parameters.sing: .*did you mean 'sign'",
        ),
        ({"profile": sw.Triangular(duration_ratio=2), "duration_ratio": 4}, "^duration_ratio: must be left out for a"),
        ({"profile": sw.Triangular(duration_ratio=2), "duration": 4}, "^rise_time: must be left out if duration"),
        ({"profile": "half-sine", "duration": 4}, "^duration: must be left out if rise_time is given, because the"),
        (
            {"profile": "half-sine", "duration_ratio": 4},
            "^duration_ratio: must be left out, because profile 'half-sine' has its own .got 4",
        ),
        ({"profile": "half-sine", "parameters": [1]}, "^parameters: must be a mapping of names to values .got .1"),
        ({"profile": sw.PowerLaw}, "^profile: must be a ShockProfile or the name of one .got <class"),
    ],
)
def test_errors_of_a_shock_state_the_key(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(sw.ShockwaveError, match=message):
        sw.Shock(**{"peak_force": 1.0, "rise_time": 1e-5, **keys})
