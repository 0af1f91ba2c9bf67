"""The commands design and uncertainty."""

from __future__ import annotations

import argparse
import sys

from attrs import evolve

from shockwave.cli.output import check_output, of_arguments, print_result
from shockwave.cli.scenario_commands import loaded
from shockwave.errors import InvalidValueError, ScenarioError, UnknownNameError, UsageError

# Hint in the error for a scenario with a sweep.
_SWEPT = "delete the `sweep` block"


def design(options: argparse.Namespace) -> int:
    """Print the values of a parameter that give the leading wave the target property."""
    from shockwave import pictures
    from shockwave.studies.design_search import design as run

    name, sign, value = options.target[-1].partition("=")
    if not sign or len(options.target) > 1:
        given = " and ".join(options.target)
        raise UsageError(f"--target must be given once as QUANTITY=VALUE, such as peak_force='60 N' (got {given!r})")
    check_output(options.output, ".svg", ".png", ".pdf")
    if options.output and options.vary == "chain.material":
        raise UsageError("--output must be omitted for chain.material (there is no axis for materials)")
    (scenario,) = loaded([options.file], _SWEPT, options.output)
    among = options.among
    if among is not None:
        among = [part.strip() for part in among.split(",") if part.strip()]
    search = {"vary": options.vary, "target": {name.strip(): value.strip()}, "between": options.between, "among": among}
    try:
        with of_arguments(options):
            found = run(scenario, **search, points=options.points, rtol=options.rtol)
    except UnknownNameError as error:
        raise UsageError(f"--among: {error}") from None
    print_result(found, options.json)
    if options.output:
        sheet, (ax,) = pictures.figure()
        pictures.design(ax, found)
        pictures.save(sheet, options.output)
        print(f"{options.output}: written", file=sys.stderr)
    # the ranking of materials is a result if the target lies in their range
    ranked = found.between is None and found.spanned
    if not found.why or ranked:
        return 0
    print(f"{options.file}: {found.why}", file=sys.stderr)
    return 1


def uncertainty(options: argparse.Namespace) -> int:
    """Print the distribution of the peak force for uncertain parameters."""
    from shockwave.studies.uncertainty_sampling import uncertainty as run

    (scenario,) = loaded([options.file], _SWEPT)
    try:
        with of_arguments(options):
            found = run(scenario, draws=options.draws, seed=options.seed, rtol=options.rtol)
    except InvalidValueError as error:
        # errors of the block are errors of the file
        if not all(fault.path.startswith("uncertainty") for fault in error.faults):
            raise
        raise ScenarioError(evolve(fault, location=options.file) for fault in error.faults) from None
    print_result(found, options.json)
    return 0
