"""The commands bench and stress."""

from __future__ import annotations

import argparse

from shockwave.base.errors import UsageError
from shockwave.cli.output import check_output, print_result, report_name_as_usage, write_output
from shockwave.cli.scenario_files import load_scenarios


def bench(options: argparse.Namespace) -> int:
    """Measure error and run time of each method."""
    from shockwave.benchmark.bench import run
    from shockwave.benchmark.bench_output import page
    from shockwave.pictures import figure

    check_output(options.output, ".html", ".htm")
    if options.changes and not options.files:
        raise UsageError("--set: must be omitted without a scenario FILE (got no FILE)")
    scenarios = load_scenarios(options, output=options.output) if options.files else []
    if options.output:
        figure()  # fails early without matplotlib
    result = run(scenarios, options.family, options.quick, options.timeout)
    print_result(result, options.json)
    if options.output:  # last, so that a page that cannot be written costs no result
        return write_output(page(result), options.output)
    return 0


def stress(options: argparse.Namespace) -> int:
    """Run the catalogue of extreme cases."""
    from shockwave.benchmark.stress import stress as run

    with report_name_as_usage("NAME"):
        result = run(options.names, options.backend)
    print_result(result, options.json)
    return result.exit_code
