"""The command curve: amplification of the leading wave as a function of the rise time."""

from __future__ import annotations

from argparse import Namespace
from functools import partial

from attrs import evolve

from shockwave import pictures
from shockwave.base.text import limits, si, strong
from shockwave.cli.output import PICTURES, check_output, json_text, write_output, write_result
from shockwave.cli.scenario_files import load_scenarios
from shockwave.scene.chain import Scales
from shockwave.scene.yielding import find_yielding, warn_beyond
from shockwave.studies.amplification_curve import UniversalCurve


def curve(options: Namespace) -> int:
    """Print or write the universal curve for the shape of a scenario's shock."""
    check_output(options.output, ".json", *PICTURES)
    (scenario,) = load_scenarios(options, output=options.output)
    with scenario.scene.locate_errors():
        chain = scenario.scene.covered_chain("the universal curve")
    shock = scenario.shock
    ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
    universal = UniversalCurve(shock.profile, rtol=options.rtol, longest=options.longest)
    if options.output and options.output.lower().endswith(".json"):
        return write_output(json_text(universal.to_dict()) + "\n", options.output)
    if options.output:
        write_result(universal, options.output, partial(pictures.universal_curves, {"simulation": universal}, ratio))
        return 0
    beyond: tuple[str, ...] = ()
    answer = f"t0/T0 = {ratio:.6g} is beyond the range of this curve (increase --longest)"
    if ratio <= universal.longest_rise_time:
        error = float(universal.error(ratio))
        amplification = si(float(universal.amplification(ratio)), "", error=error)
        answer = f"amplification {amplification}, error {error:.0e}, at t0/T0 = {ratio:.6g}"
        force = float(universal.amplification(ratio)) * shock.peak_force
        beyond = warn_beyond(find_yielding(chain, force), evolve(chain, granules=None))
    endless = [f"the chain of {chain.count} granules is treated as endless"] * (chain.count is not None)
    print(strong(answer), *limits([*endless, *beyond]), "", universal, sep="\n")
    return 0
