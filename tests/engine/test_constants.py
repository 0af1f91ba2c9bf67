"""Constants of the C files: those that the NumPy code has under the same name are equal."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from attrs import fields

from shockwave.engine import chain_arrays, chain_backend, chain_forces, chain_peaks, chain_run
from shockwave.engine.chain_arrays import Progress, Settings

ENGINE = Path(__file__).parents[2] / "shockwave" / "engine"
#: Modules with the algorithms of a header.
TWINS = {
    "_lane.h": ["engine.wave_search_numpy", "engine.peak_limit", "engine.nystroem_integrators"],
    "_march.h": ["engine.chain_arrays", "engine.chain_forces"],
    "_peak_log.h": ["engine.peak_log"],
    "_plastic.h": ["engine.chain_forces", "engine.chain_modes", "engine.chain_plastic"],
    "_wave.h": ["simulation.wave_properties"],
    "_window.h": ["engine.force_law"],
}
#: Names in C of constants with another name in NumPy.
OTHER_NAMES = {"TURNS": "CORRECTIONS"}
#: Sizes of buffers, and limits, that only the C files have.
SIZES = {"BLOCK", "MAX_STAGES", "MOST_BUFFERS", "NODES", "PARTS", "PLASTIC_ROWS", "ROW", "SHARED", "WIDTH"}
ONLY_C = SIZES | {"FEW", "INTERVAL", "MIN_OVERLAP"}


def constants() -> Iterator[tuple[str, str, float]]:
    """File, name and value of all constants that are numbers."""
    for file in sorted(ENGINE.glob("_*.[ch]")):
        for name, value in re.findall(r"^#define (\w+) ([\d.]+(?:e-?\d+)?)(?=\s)", file.read_text(), re.MULTILINE):
            yield file.name, name, float(value)


@pytest.mark.parametrize(("file", "name", "value"), [each for each in constants() if each[1] not in ONLY_C])
def test_constants_in_c_are_those_of_the_numpy_code(file: str, name: str, value: float) -> None:
    name = OTHER_NAMES.get(name, name)
    modules = [vars(import_module(f"shockwave.{module}")) for module in TWINS[file]]
    values = {module.get(name, module.get(f"_{name}")) for module in modules} - {None}
    assert values == {value}


def test_every_constant_that_only_c_has_exists() -> None:
    assert {name for _, name, _ in constants()} > ONLY_C


#: Names in C of numbers of a run with another name in NumPy, or with several elements.
OF_A_RUN = {"extremes": ["extremes", "extreme_times"]}
OTHER_CONSTANTS = {"step_work": "compiled_step"}


def test_numbers_of_a_run_have_the_same_order_in_both_codes() -> None:
    struct = re.search(r"typedef struct {([^}]*)} Run;", (ENGINE / "_march.h").read_text())
    assert struct is not None
    names = [each for each in re.findall(r"[a-z]\w*", re.sub(r"\[3\]", "", struct[1])) if each != "double"]
    before, after = Settings._fields, [each.name for each in fields(Progress)]
    before, after = [*before, "window"], [each for name in after for each in OF_A_RUN.get(name, [name])]
    assert names[: len(before)] == before
    assert names[-len(after) :] == after
    constants, values = names[len(before) : -len(after)], chain_backend._constants(True)
    assert len(constants) == len(values)
    modules = [vars(each) for each in (chain_backend, chain_arrays, chain_forces, chain_peaks, chain_run)]
    for name, value in zip(constants, values, strict=True):
        wanted = OTHER_CONSTANTS.get(name, name).upper()
        assert value in [module.get(each) for module in modules for each in (wanted, f"_{wanted}")], name
