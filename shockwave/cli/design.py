"""Commands on scenes that differ from a scenario: design, uncertainty."""

from __future__ import annotations

import argparse
import sys

from shockwave.cli.output import print_json
from shockwave.cli.scenes import loaded
from shockwave.errors import UsageError

__all__ = ["design", "uncertainty"]


def design(options: argparse.Namespace) -> int:
    """Values at which the primary is as wanted."""
    from shockwave.designs.design import design as run

    name, sign, value = options.target.partition("=")
    if not sign:
        raise UsageError(f"--target must be QUANTITY=VALUE, such as peak_force='60 N' (got {options.target!r})")
    scenarios, status = loaded([options.file])
    if status:
        return status
    among = None if options.among is None else [part.strip() for part in options.among.split(",") if part.strip()]
    found = run(
        scenarios[0],
        vary=options.vary,
        target={name.strip(): value.strip()},
        between=options.between,
        among=among,
        points=options.points,
        rtol=options.rtol,
    )
    if options.output:
        from shockwave.designs.picture import write

        write(found, options.output)
        print(f"{options.output}: written", file=sys.stderr)
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    if found.why:
        print(f"{options.file}: {found.why}", file=sys.stderr)
        return 1
    return 0


def uncertainty(options: argparse.Namespace) -> int:
    """Distribution of the primary where values are uncertain."""
    from shockwave.uncertainties.uncertainty import uncertainty as run

    scenarios, status = loaded([options.file])
    if status:
        return status
    found = run(scenarios[0], draws=options.draws, seed=options.seed, rtol=options.rtol)
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    return 0
