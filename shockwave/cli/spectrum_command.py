"""The command spectrum: shock response spectrum of what reaches the structure."""

from __future__ import annotations

from argparse import Namespace

from shockwave import answers, pictures
from shockwave.cli.output import announce_file, check_output, of_arguments, print_result
from shockwave.cli.scenario_files import load_scenarios
from shockwave.simulation.shock_spectrum import FREQUENCY

_TABLES = (".csv", ".nc")


def spectrum(options: Namespace) -> int:
    """Print the spectrum, or write it as a table or a picture."""
    check_output(options.output, *_TABLES, ".svg", ".png", ".pdf")
    (scenario,) = load_scenarios(options, output=options.output)
    with of_arguments(options), scenario.scene.locate_errors():
        low, high = (FREQUENCY.check(name, getattr(options, name)) for name in ("from", "to"))
        simulated = answers.simulate(scenario)
        result = simulated.spectrum(mass=options.mass, damping=options.damping, low=low, high=high)
    print_result(result, options.json)
    if options.output:
        with announce_file(options.output):
            if options.output.lower().endswith(_TABLES):
                result.write(options.output)
            else:
                pictures.save(result.plot(ax=pictures.figure()[1][0]), options.output)
    return 0
