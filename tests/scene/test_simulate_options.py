"""How a simulation is asked for: what a method has no use for is refused, every method gives the same answer."""

from __future__ import annotations

import re
from pathlib import Path

import attrs
import pytest

import shockwave as sw
from shockwave.registry.registry import entries, load
from shockwave.scene.simulate_options import SimulateOptions
from support import scenario_texts
from support.command_line import scenario, shockwave
from support.scenes import CASE_A, CHAIN, FORCE, power

# setting and method that has no use for it, a part of the message
USELESS = {
    "rtol-of-fixed-step": ({"integrator": "verlet", "rtol": 1e-5}, "rtol", "verlet has a fixed step size (got 1e-05"),
    "step-of-adaptive": ({"integrator": "rkn86", "step": 0.01}, "step", "rkn86 chooses its own steps (got 0.01; give"),
    "step-of-none": ({"step": 0.01}, "step", "chooses its own steps (got 0.01; give rtol)"),
    "compiled-of-another": (
        {"integrator": "dop853", "backend": "compiled"}, "backend", "dop853 is compiled for some chains only",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", USELESS)
def test_setting_without_use_is_refused(name: str, tmp_path: Path) -> None:
    settings, setting, part = USELESS[name]
    for run in (sw.simulate, lambda shock, chain, **given: sw.simulate_many([shock], chain, **given)):
        with pytest.raises(sw.InvalidValueError, match=f"^{setting}: must be.*{re.escape(part)}"):
            run(CASE_A, CHAIN, **settings)  # type: ignore[operator]
    arguments = [word for key, value in settings.items() for word in (f"--{key}", value)]
    answer = shockwave("simulate", *arguments, scenario(tmp_path, scenario_texts.CHAIN + scenario_texts.SHOCK))
    assert answer.status == 2
    assert part in answer.err


def test_a_method_of_the_command_line_replaces_the_settings_of_another(tmp_path: Path) -> None:
    chain = scenario_texts.CHAIN.replace("1 mm", "1 mm, granules: 10")
    file = scenario(tmp_path, chain + scenario_texts.SHOCK, "simulate: {rtol: 1e-5, waves: primary}")
    answer = shockwave("simulate", "--verbose", "--integrator", "verlet", "--step", "0.1", file)
    assert answer.status == 0
    assert "verlet" in answer.out


WRONG = {
    "waves": ("waves", "all", "must be train or primary"),
    "record": ("record", ["speeds"], r"\[0\]: must be forces, field or energies"),
    "record-without-a-list": ("record", 5, "must be a list"),
    "sensor-without-a-list": ("sensors", {"contact": 1}, "must be a list"),
    "negative-contact": (
        "contacts",
        [-1, 2.5],
        r"\[0\]: must be a whole number >= 0.*\ncontacts\[1\]: must be a whole",
    ),
    "contact-of-text": ("contacts", "12", "must be a list"),
    "wave-threshold": ("wave_threshold", 1e-4, "must be >= 0.001 and < 1"),
}


@pytest.mark.parametrize("name", WRONG)
def test_setting_out_of_range_is_refused(name: str) -> None:
    setting, value, rule = WRONG[name]
    with pytest.raises(sw.InvalidValueError, match=f"{setting}(: )?{rule}"):
        SimulateOptions(**{setting: value})  # type: ignore[arg-type]


@pytest.mark.parametrize(("rtol", "name"), [(None, "rkn86"), (1e-7, "rkn86"), (0.9e-7, "rkn1210")])
def test_method_is_chosen_for_the_tolerance(rtol: float | None, name: str) -> None:
    assert sw.simulate(CASE_A, CHAIN, rtol=rtol).integrator == name


def test_result_states_its_settings() -> None:
    adaptive = sw.simulate(power(0.5), CHAIN)
    fixed = sw.simulate(power(0.5), CHAIN, integrator="verlet", waves="primary")
    chosen = sw.simulate(power(0.5), attrs.evolve(CHAIN, granules=12), integrator="rk4", step=0.1, waves="primary")
    assert [(each.rtol, each.options.step) for each in (adaptive, fixed, chosen)] == [
        (1e-6, None),
        (None, 0.02),
        (None, 0.1),
    ]
    assert chosen.to_dict()["step"] == 0.1


INTEGRATORS = [
    pytest.param(entry.name, marks=[pytest.mark.slow] * (entry.name in ("radau", "rk4", "verlet")))
    for entry in entries("integrators")
]


@pytest.mark.parametrize("name", INTEGRATORS)
def test_every_method_agrees_with_the_reference_to_its_estimate(name: str) -> None:
    # Radau is of order 5 and implicit, and takes its time
    rtol = 1e-3 if name == "radau" else 1e-4 if load("integrators", name).adaptive else None
    step = 0.1 if rtol is None else None
    result = sw.simulate(CASE_A, CHAIN, rtol=rtol, step=step, integrator=name, waves="primary")
    # contact 60 of this chain, known to 19 digits, is within 1e-11 of its limit
    assert abs(result.peak_force / FORCE / 1.505133369796510557 - 1) <= result.error_estimate
    assert result.rtol is None or result.error_estimate <= result.rtol
