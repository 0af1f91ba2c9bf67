"""The methods on chains of granules: the default's answers, contacts that open, and what each costs."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shockwave.hooks import OneStep
from shockwave.registry.registry import load

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.verlet_richardson import VerletRichardson

SPLITTING = [BlanesMoan4, BlanesMoan6, BlanesMoan6Long]
README = Path(__file__).parent.parent / "README.md"

SCENE = """
chain: {material: paper-steel, diameter: 9.5 mm}
shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}
"""


def _peak_force(folder: Path, *options: str) -> float:
    (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
    command = [sys.executable, "-W", "error", "-m", "shockwave", "simulate", "--primary", "--json", *options]
    output = subprocess.run(
        [*command, "scene.yaml"], cwd=folder, check=True, capture_output=True, text=True, timeout=60
    ).stdout
    found = json.loads(output)
    return float((found[0] if isinstance(found, list) else found)["peak_force"])


@pytest.mark.parametrize(
    "options",
    [
        ("--integrator", "blanes-moan-4", "--step", "0.02"),
        ("--integrator", "blanes-moan-6", "--step", "0.1"),
        ("--integrator", "blanes-moan-6-long", "--step", "0.1"),
        ("--integrator", "verlet-richardson", "--rtol", "1e-7"),
    ],
    ids=lambda options: options[1],
)
def test_the_command_line_gives_the_answer_of_the_default(tmp_path: Path, options: tuple[str, ...]) -> None:
    # peaks are read off a chain in which the wave has settled to 1e-7 or so
    assert _peak_force(tmp_path, *options) == pytest.approx(_peak_force(tmp_path), rel=1e-6)


# --- a collision of two granules, whose end is known ------------------------------------------------------


def _pair(_: Any, x: np.ndarray) -> np.ndarray:
    force = np.maximum(x[0] - x[1], 0.0) ** 1.5
    return np.stack((-force, force))


def _exchange_error(method: OneStep, size: float) -> float:
    """Error of the velocities, which a collision exchanges; root mean square over steps near to ``size``.

    The places where they meet beginning and end of the contact are spread evenly; for any one step the two
    errors may cancel.
    """
    places = np.arange(300)
    sizes = size * (0.8 + 0.4 * (places * np.sqrt(2) % 1))
    gaps = 0.1 + sizes * (places * np.sqrt(3) % 1)
    x, v = np.stack((-gaps, 0 * gaps)), np.stack((1 + 0 * gaps, 0 * gaps))
    a = _pair(0, x)
    # the gap and then the contact are passed in less than 4
    for index in range(int(np.ceil(5 / size))):
        x, v, a, _ = method.attempt(_pair, index * sizes, sizes, x, v, a)
    assert np.all(x[1] > x[0])
    return float(np.sqrt(np.mean((v[1] - 1) ** 2)))


@pytest.mark.parametrize("method", SPLITTING, ids=lambda method: method.name)
def test_where_a_contact_closes_or_opens_the_error_goes_with_five_halves_of_the_step(
    method: type[OneStep],
) -> None:
    coarse, fine = (_exchange_error(method(), size) for size in (0.04, 0.01))
    # the force scales as t^(3/2) there, its impulse as t^(5/2); 300 places leave a few hundredths
    assert np.log(coarse / fine) / np.log(4) == pytest.approx(2.5, abs=0.1)


def test_steps_that_adapt_meet_the_tolerance_all_the_same() -> None:
    *_, last = VerletRichardson(tolerance=1e-9).steps(
        _pair, 0.0, 5.0, np.array([-0.3, 0.0]), np.array([1.0, 0.0]), None
    )
    assert last.v == pytest.approx([0.0, 1.0], abs=3e-8)


# --- the tables of the README -----------------------------------------------------------------------------

GRANULES, SPAN = 40, 20.0
PER_STEP = {"verlet": 1, "pefrl": 5, "blanes-moan-4": 6, "blanes-moan-6": 11, "blanes-moan-6-long": 15}


def _chain(_: Any, x: np.ndarray, pressed: float) -> np.ndarray:
    overlap = np.maximum(pressed + x[:-1] - x[1:], 0.0)
    force = overlap * np.sqrt(overlap) - pressed
    return np.append(0.0, force) - np.append(force, 0.0)


def _run(name: str, problem: str, **settings: float) -> tuple[np.ndarray, int]:
    """Positions and velocities at the end, and evaluations."""
    x, v = np.zeros((2, GRANULES))
    pressed = 1.0 if problem == "pressed" else 0.0
    v[:] = 0.3 * np.sin(0.3 * np.arange(GRANULES)) if pressed else np.eye(1, GRANULES)[0]
    method = load("integrators", name)(**settings)
    *_, last = method.steps(lambda time, x: _chain(time, x, pressed), 0.0, SPAN, x, v, None)
    return np.array([last.x, last.v]), method.evaluations


@pytest.fixture(scope="module")
def exact() -> dict[str, np.ndarray]:
    return {name: _run("rkn1210", name, tolerance=1e-14)[0] for name in ("pressed", "struck")}


def _fixed_error(name: str, problem: str, evaluations: int, exact: np.ndarray) -> float:
    """Greatest error at the end; on the struck chain the mean, in logarithms, of steps near to each other."""
    count = round(evaluations / PER_STEP[name])
    counts = [count] if problem == "pressed" else [count + more * count // 40 for more in range(4)]
    errors = [np.max(np.abs(_run(name, problem, size=SPAN / n)[0] - exact)) for n in counts]
    return float(np.exp(np.mean(np.log(errors))))


def _energy_change(name: str, size: float, speed: float) -> float:
    """Greatest relative change of the energy of the pressed chain in 400 units of time."""
    v = speed * np.sin(0.3 * np.arange(GRANULES))
    run = load("integrators", name)(size=size).steps(
        lambda time, x: _chain(time, x, 1.0), 0.0, 400.0, np.zeros(GRANULES), v - np.mean(v), None
    )
    energies = []
    for step in run:
        overlap = np.maximum(1 + step.x[:-1] - step.x[1:], 0.0)
        potential = np.sum(overlap**2.5) / 2.5 + step.x[-1] - step.x[0]
        energies.append(step.v @ step.v / 2 + potential)
    return float(np.ptp(energies) / energies[0])


@pytest.mark.parametrize(
    ("name", "size", "most"), [("blanes-moan-4", 0.2, 2e-10), ("blanes-moan-6", 0.4, 4e-11)]
)
def test_energy_is_kept_while_contacts_stay_closed(name: str, size: float, most: float) -> None:
    # measured: 7e-11 and 1.1e-11, with room for rounding; rk4 at the cost of the first loses 3e-6
    assert _energy_change(name, size, 0.3) < most


@pytest.mark.parametrize(("name", "size"), [("blanes-moan-4", 0.2), ("blanes-moan-6", 0.4)])
def test_energy_wanders_where_contacts_open(name: str, size: float) -> None:
    assert _energy_change(name, size, 2.0) > 1e-6


def _table(title: str) -> tuple[list[str], list[list[str]]]:
    text = README.read_text(encoding="utf-8")
    lines = text[text.index(f"<!-- table: {title} -->") :].splitlines()[1:]
    rows = []
    for line in lines:
        if line.startswith("|"):
            rows.append([cell.strip(" `") for cell in line.split("|")[1:-1]])
        elif rows:
            break
    return rows[0], rows[2:]


def test_the_errors_of_fixed_steps_are_those_of_the_readme(exact: dict[str, np.ndarray]) -> None:
    head, rows = _table("fixed steps")
    assert [row[0] for row in rows] == list(PER_STEP)
    columns = [re.fullmatch(r"(pressed|struck), (\d+)", cell) for cell in head[1:]]
    for name, *cells in rows:
        for column, stated in zip(columns, cells, strict=True):
            assert column is not None
            found = _fixed_error(name, column[1], int(column[2]), exact[column[1]])
            # two digits are shown
            assert found == pytest.approx(float(stated), rel=0.06), f"{name}, {column[0]}: {found:.1e}"


def test_the_errors_of_adaptive_steps_are_those_of_the_readme(exact: dict[str, np.ndarray]) -> None:
    _, rows = _table("adaptive steps")
    for name, tolerance, *cells in rows:
        for problem, evaluations, stated in zip(("pressed", "struck"), cells[::2], cells[1::2], strict=True):
            end, counted = _run(name, problem, tolerance=float(tolerance))
            error = float(np.max(np.abs(end - exact[problem])))
            shown = f"{name}, {tolerance}, {problem}: {counted}, {error:.1e}"
            # rounding may cost an attempt more or less
            assert counted == pytest.approx(int(evaluations), rel=0.02), shown
            assert error == pytest.approx(float(stated), rel=0.06), shown
