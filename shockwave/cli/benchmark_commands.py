"""The commands bench and stress."""

from __future__ import annotations

import argparse

from shockwave.cli.output import check_output, print_result, write_output
from shockwave.cli.scenario_commands import load_scenarios


def bench(options: argparse.Namespace) -> int:
    """Measure error and run time of each method."""
    from shockwave.benchmark.bench import run
    from shockwave.benchmark.bench_output import page
    from shockwave.pictures import figure

    check_output(options.output, ".html", ".htm")
    scenarios = load_scenarios(options.files, output=options.output)
    if options.output:
        figure()  # fails early without matplotlib
    found = run(scenarios, options.family, options.quick, options.longest)
    print_result(found, options.json)
    if options.output:  # last, so that a page that cannot be written costs no result
        return write_output(page(found), options.output)
    return 0


def stress(options: argparse.Namespace) -> int:
    """Run the catalogue of extreme cases."""
    from shockwave.benchmark.stress import stress as run

    found = run(options.names, options.backend)
    print_result(found, options.json)
    return found.exit_code
