"""The commands design and uncertainty."""

from __future__ import annotations

import argparse
from typing import Any

from attrs import evolve

from shockwave.base.errors import InvalidValueError, ScenarioError, UsageError
from shockwave.base.quantity_fields import join
from shockwave.cli.output import (
    PICTURES,
    check_output,
    print_result,
    report_as_usage,
    report_name_as_usage,
    write_result,
)
from shockwave.cli.scenario_files import load_scenarios, name_of
from shockwave.scenario.block_keys import MATERIALS

# Hint in the error for a scenario with a sweep.
_SWEPT = "delete the `sweep` block"


def design(options: argparse.Namespace) -> int:
    """Print the values of parameters that meet requirements."""
    from shockwave.studies.design_search import design as run

    check_output(options.output, *PICTURES)
    vary = _parse_parameters(options)
    (scenario,) = load_scenarios(options, _SWEPT, options.output)
    with report_name_as_usage("--among"), report_as_usage(options), scenario.scene.locate_errors():
        result = run(
            scenario,
            vary=vary,
            target=options.target,
            budget=options.budget,
            least=options.least,
            points=options.points,
            rtol=options.rtol,
            seed=options.seed,
        )
    print_result(result, options.json)  # with the reason if there is no solution
    if options.output:
        from shockwave.pictures.studies import ranking_size

        ranked = result.is_ranked and result.least is None
        write_result(result, options.output, size=ranking_size(result) if ranked else "column")
    # the ranking of materials or whole numbers is a result if the target lies in their range
    return 0 if not result.why or (result.least is None and result.is_ranked and result.spanned) else 1


def _parse_parameters(options: argparse.Namespace) -> dict[str, Any]:
    """The parameters, with their intervals or materials."""
    if len(set(options.vary)) < len(options.vary):
        raise UsageError(f"--vary must name different parameters (got {join(options.vary, 'and')})")
    numbers = [name for name in options.vary if not name.endswith(MATERIALS)]
    if len(options.between) != len(numbers):
        got = f"got {len(options.between)} for {join(numbers, 'and') if numbers else 'materials alone'}"
        raise UsageError(f"--between must be given once for each number that varies ({got})")
    if options.among is not None and len(numbers) == len(options.vary):
        raise UsageError(f"--among must be omitted for {join(numbers, 'and')} (got {options.among})")
    among = options.among and [part.strip() for part in options.among.split(",") if part.strip()]
    ends = dict(zip(numbers, options.between, strict=True))
    return {name: ends.get(name, among) for name in options.vary}


def uncertainty(options: argparse.Namespace) -> int:
    """Print the distribution of the peak force for uncertain parameters."""
    from shockwave.studies.uncertainty_study import uncertainty as run

    check_output(options.output, *PICTURES)
    (scenario,) = load_scenarios(options, _SWEPT, options.output)
    try:
        with report_as_usage(options), scenario.scene.locate_errors():
            result = run(
                scenario, draws=options.draws, seed=options.seed, rtol=options.rtol, quantities=options.quantities
            )
    except InvalidValueError as error:
        # errors of the block are errors of the file
        if not all(fault.path.startswith("uncertainty") for fault in error.faults):
            raise
        faults = (evolve(fault, location=fault.location or name_of(scenario)) for fault in error.faults)
        raise ScenarioError(*faults) from None
    print_result(result, options.json)
    if options.output:
        write_result(result, options.output)
    return 0
