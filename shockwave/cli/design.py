"""The commands design and uncertainty."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from attrs import evolve

from shockwave.cli.output import check_output, of_arguments, print_result
from shockwave.cli.scenario_commands import loaded, located
from shockwave.errors import InvalidValueError, ScenarioError, UnknownNameError, UsageError
from shockwave.fields import listed
from shockwave.scenario.block_keys import MATERIALS
from shockwave.scenario.scenario import Scenario

# Hint in the error for a scenario with a sweep.
_SWEPT = "delete the `sweep` block"


def design(options: argparse.Namespace) -> int:
    """Print the values of parameters that meet requirements."""
    from shockwave.studies.quantities import parts_of

    check_output(options.output, ".svg", ".png", ".pdf")
    if len(set(options.vary)) < len(options.vary):
        raise UsageError(f"--vary must name different parameters (got {listed(options.vary, 'and')})")
    numbers = [name for name in options.vary if not name.endswith(MATERIALS)]
    if len(options.between) != len(numbers):
        got = f"got {len(options.between)} for {listed(numbers, 'and') if numbers else 'materials alone'}"
        raise UsageError(f"--between must be given once for each number that varies ({got})")
    (scenario,) = loaded([options.file], _SWEPT, options.output)
    among = options.among and [part.strip() for part in options.among.split(",") if part.strip()]
    try:
        with of_arguments(options), located(scenario):
            wanted = [parts_of(text, "target") for text in options.target]
            if len(options.vary) == len(wanted) == 1 and not (options.budget or options.least):
                found = _one(options, scenario, wanted[0], among)
            else:
                found = _several(options, scenario, numbers, among)
    except UnknownNameError as error:
        raise UsageError(f"--among: {error}") from None
    print_result(found, options.json)
    if options.output:
        _draw(found, options.output)
        print(f"{options.output}: written", file=sys.stderr)
    # the ranking of materials or whole numbers is a result if the target lies in their range
    if not found.why or (isinstance(found.vary, str) and found.between is None and found.spanned):
        return 0
    print(f"{options.file}: {found.why}", file=sys.stderr)
    return 1


def _one(options: argparse.Namespace, scenario: Scenario, wanted: tuple[str, str, str], among: list[str] | None) -> Any:
    """All values of one parameter that meet a requirement."""
    from shockwave.studies.design_search import design as run

    name, sign, value = wanted
    (vary,), between = options.vary, next(iter(options.between), None)
    search = {"vary": vary, "target": {name: value}, "sign": sign, "between": between, "among": among}
    return run(scenario, **search, points=options.points, rtol=options.rtol)


def _several(options: argparse.Namespace, scenario: Scenario, numbers: list[str], among: list[str] | None) -> Any:
    """The values of several parameters that meet all requirements and minimise a quantity."""
    from shockwave.studies.optimal_design import optimal_design as run

    if among is not None and len(numbers) == len(options.vary):
        raise UsageError(f"--among must be omitted for {listed(numbers, 'and')} (got {options.among})")
    ends = dict(zip(numbers, options.between, strict=True))
    return run(
        scenario,
        vary={name: ends.get(name, among) for name in options.vary},
        targets=options.target,
        budgets=options.budget,
        least=options.least or "chain.mass",
        seed=options.seed,
    )


def _draw(found: Any, output: str) -> None:
    """Write a picture: the property or a ranking of materials; for several parameters, also the options."""
    from shockwave import pictures

    several = not isinstance(found.vary, str)
    ranked = found.ranking if several else found.table if found.between is None else ()
    sheet, axes = pictures.ranked_figure(len(ranked), 2 if several else 1) if ranked else pictures.figure()
    if ranked:
        pictures.materials(axes[0], found)
    if several:
        pictures.pareto(axes[-1], found)
    elif not ranked:
        pictures.design(axes[0], found)
    pictures.save(sheet, output)


def uncertainty(options: argparse.Namespace) -> int:
    """Print the distribution of the peak force for uncertain parameters."""
    from shockwave.studies.uncertainty_sampling import uncertainty as run

    (scenario,) = loaded([options.file], _SWEPT)
    try:
        with of_arguments(options), located(scenario):
            found = run(scenario, draws=options.draws, seed=options.seed, rtol=options.rtol, limit=options.limit)
    except InvalidValueError as error:
        # errors of the block are errors of the file
        if not all(fault.path.startswith("uncertainty") for fault in error.faults):
            raise
        faults = [evolve(fault, location=fault.location or options.file) for fault in error.faults]
        raise ScenarioError(faults) from None
    print_result(found, options.json)
    return 0
