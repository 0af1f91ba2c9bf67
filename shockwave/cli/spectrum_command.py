"""The command spectrum: shock response spectrum of what reaches the structure."""

from __future__ import annotations

from argparse import Namespace

from shockwave import answers
from shockwave.cli.output import PICTURES, TABLES, check_output, print_result, report_as_usage, write_result
from shockwave.cli.scenario_files import load_scenarios
from shockwave.simulation.shock_spectrum import FREQUENCY


def spectrum(options: Namespace) -> int:
    """Print the spectrum, or write it as a table or a picture."""
    check_output(options.output, *TABLES, *PICTURES)
    (scenario,) = load_scenarios(options, output=options.output)
    with report_as_usage(options), scenario.scene.locate_errors():
        low, high = (FREQUENCY.check(name, getattr(options, name)) for name in ("from", "to"))
        simulated = answers.simulate(scenario)
        result = simulated.spectrum(mass=options.mass, damping=options.damping, low=low, high=high)
    print_result(result, options.json)
    if options.output:
        write_result(result, options.output)
    return 0
