"""Commands on scenes that differ from a scenario: design, uncertainty."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from attrs import evolve

from shockwave.cli.output import print_json
from shockwave.cli.scenes import loaded
from shockwave.errors import InvalidValueError, ScenarioError, UnknownNameError, UsageError

# What to do with a scenario that stands for many.
_SWEPT = "delete the block sweep"


@contextmanager
def _of_arguments(options: argparse.Namespace) -> Iterator[None]:
    """A fault of an argument is one of the call, not of a scenario."""
    try:
        yield
    except InvalidValueError as error:
        parts = [fault.path.partition(".") for fault in error.faults]
        if not all(name in vars(options) for name, _, _ in parts):
            raise
        told = ((f"--{name}", rest, fault.problem) for (name, _, rest), fault in zip(parts, error.faults, strict=True))
        raise UsageError("\n".join(": ".join(filter(None, one)) for one in told)) from None
    except UnknownNameError as error:
        if error.exit_code != UnknownNameError.exit_code:  # a plugin is at fault
            raise
        raise UsageError(f"--among: {error}") from None


@contextmanager
def _of_file(file: str) -> Iterator[None]:
    """A fault of the block is told with its file."""
    try:
        yield
    except InvalidValueError as error:
        if any(fault.path.partition(".")[0] != "uncertainty" for fault in error.faults):
            raise
        raise ScenarioError(evolve(fault, location=file) for fault in error.faults) from None


def design(options: argparse.Namespace) -> int:
    """Values at which the primary is as wanted."""
    from shockwave.studies.design_search import design as run

    given = options.target[-1]
    name, sign, value = given.partition("=")
    if not sign:
        raise UsageError(f"--target must be QUANTITY=VALUE, such as peak_force='60 N' (got {given!r})")
    if len(options.target) > 1:
        raise UsageError(f"--target must be given once (got {' and '.join(options.target)}; run one design for each)")
    if options.output:
        from shockwave.studies.study_pictures import PICTURES, checked, write_design

        with _of_arguments(options):
            checked(options.output, PICTURES, options.vary)
    scenarios, status = loaded([options.file], _SWEPT, options.output)
    if status:
        return status
    among = None if options.among is None else [part.strip() for part in options.among.split(",") if part.strip()]
    with _of_arguments(options):
        found = run(
            scenarios[0],
            vary=options.vary,
            target={name.strip(): value.strip()},
            between=options.between,
            among=among,
            points=options.points,
            rtol=options.rtol,
        )
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    if options.output:
        write_design(found, options.output)
        print(f"{options.output}: written", file=sys.stderr)
    if found.why:
        print(f"{options.file}: {found.why}", file=sys.stderr)
    # materials in whose range the target lies are ranked: that is the answer
    return 1 if found.why and not (found.between is None and found.spanned) else 0


def uncertainty(options: argparse.Namespace) -> int:
    """Distribution of the primary where values are uncertain."""
    from shockwave.studies.uncertainty_sampling import uncertainty as run

    scenarios, status = loaded([options.file], _SWEPT)
    if status:
        return status
    with _of_arguments(options), _of_file(options.file):
        found = run(scenarios[0], draws=options.draws, seed=options.seed, rtol=options.rtol)
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    return 0
