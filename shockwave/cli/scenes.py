"""Commands on scenario files: predict, simulate, compare, validate, report, curve."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from attrs import evolve

from shockwave.cli.output import failure, of_arguments, print_json, written
from shockwave.cli.result_tables import comparison_table, outcome_table, simulation_table
from shockwave.errors import Fault, ShockwaveError, UsageError
from shockwave.files import refuse_inputs

if TYPE_CHECKING:
    from shockwave.options import SimulateOptions
    from shockwave.scenario.scenario import Scenario


def loaded(files: Sequence[str], remedy: str = "", output: str | None = None) -> list[Scenario]:
    """All scenarios; one that stands for many is an error here, and ``remedy`` or to run the sweep its hint.

    Raises
    ------
    ShockwaveError
        All errors of all files, with the greatest exit status of them; or ``output`` is one of the input files.
    """
    scenarios = []
    errors = []
    for file in files:
        try:
            scenarios.append(_single(file, remedy or f"run `shockwave sweep {file}`"))
        except ShockwaveError as error:
            errors.append(error)
    if errors:
        together = ShockwaveError("\n".join(map(str, errors)))
        together.exit_code = max(error.exit_code for error in errors)
        raise together
    if output:
        refuse_inputs(output, (file for scenario in scenarios for file in scenario.files))
    return scenarios


def _single(file: str, remedy: str) -> Scenario:
    from shockwave.scenario.loader import load_scenario

    scenario = load_scenario(file)
    if scenario.sweep is not None:
        got = f"got a sweep of {len(scenario.sweep)}; {remedy}"
        raise UsageError(f"{file}: must be a single scene ({got})")
    return scenario


def _run(options: argparse.Namespace, one: Callable[[Scenario], Any], several: Callable[[list[Any]], str]) -> int:
    """Do ``one`` for every scenario and print the results; a failure is reported and does not stop the others."""
    status = 0
    done = []
    documents = []
    scenarios = loaded(options.files)
    for number, scenario in enumerate(scenarios, start=1):
        if len(scenarios) > 1 and sys.stderr.isatty():
            print(f"{number} of {len(scenarios)}: {scenario.name}", file=sys.stderr)
        try:
            result = one(scenario)
            # parts of a result that are computed when they are used may fail, too
            documents.append(result.to_dict())
            done.append(result)
        except Exception as error:
            text, code = failure(error)
            print(f"{scenario.path}: {text}", file=sys.stderr)
            documents.append({"scenario": scenario.name, "error": text})
            status = max(status, code)
        except KeyboardInterrupt:
            print(f"{scenario.path}: interrupted; the results before it follow", file=sys.stderr)
            status = 130
            break
    single = len(options.files) == 1
    if options.json and documents:
        print_json(documents[0] if single else documents)
    elif done:
        print(done[0] if single else several(done))
    return status


def predict(options: argparse.Namespace) -> int:
    def one(scenario: Scenario) -> Any:
        outcome = scenario.predictor.predict(scenario.shock, scenario.chain)
        return evolve(outcome, scenario=scenario.name)

    return _run(options, one, outcome_table)


def simulate(options: argparse.Namespace) -> int:
    from shockwave.measurement.simulate import simulate_with

    def one(scenario: Scenario) -> Any:
        result = simulate_with(_settings(options, scenario), scenario.shock, scenario.chain)
        return evolve(result, scenario=scenario.name)

    return _run(options, one, simulation_table)


def compare(options: argparse.Namespace) -> int:
    from shockwave.studies.comparison import compare as compared

    def one(scenario: Scenario) -> Any:
        found = compared(scenario.shock, scenario.chain, scenario.predictor, _settings(options, scenario))
        return evolve(
            found,
            published=scenario.published,
            predicted=evolve(found.predicted, scenario=scenario.name),
            simulated=evolve(found.simulated, scenario=scenario.name),
        )

    return _run(options, one, comparison_table)


def _settings(options: argparse.Namespace, scenario: Scenario) -> SimulateOptions:
    """The scenario's block ``simulate``, with the options of the command line in its place."""
    names = ("rtol", "step", "integrator", "backend", "contacts")
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if options.primary:
        given["waves"] = "primary"
    # a method named here has a use for its own settings, not for those of the one that it replaces
    if "integrator" in given:
        given = {"rtol": None, "step": None} | given
    return evolve(scenario.simulate, **given)


def validate(options: argparse.Namespace) -> int:
    from shockwave.scenario.loader import load_scenario

    status = 0
    documents = []
    for file in options.files:
        faults: Sequence[Fault] = ()
        try:
            load_scenario(file)
        except ShockwaveError as error:
            faults = getattr(error, "faults", ()) or [Fault("", str(error))]
            status = max(status, error.exit_code)
        listed = [{"location": f.location, "path": f.path, "problem": f.problem} for f in faults]
        documents.append({"file": file, "valid": not faults, "faults": listed})
        if not options.json:
            print("\n".join(map(str, faults)) or f"{file}: valid")
    if options.json:
        print_json(documents if len(documents) > 1 else documents[0])
    return status


def report(options: argparse.Namespace) -> int:
    """One page on a scenario."""
    from shockwave.page import findings
    from shockwave.page import written as page
    from shockwave.pictures import figure

    (scenario,) = loaded([options.file], output=options.output)
    figure()  # what the page needs is looked for before anything is computed
    found = findings(scenario)
    for failed in found.failures:
        print(f"{options.file}: {failed}", file=sys.stderr)
    written(page(found), options.output)
    return 1 if found.failures else 0


def curve(options: argparse.Namespace) -> int:
    """The universal curve of a scenario's shape."""
    from shockwave.chain import Scales
    from shockwave.studies.curve_and_design_files import CURVE_FILES, check_output, write_curve
    from shockwave.studies.universal_curve import UniversalCurve

    if options.output:
        with of_arguments(options):
            check_output(options.output, CURVE_FILES)
    (scenario,) = loaded([options.file], output=options.output)
    shock = scenario.shock
    ratio = Scales.of(scenario.chain, shock.peak_force).rise_time(shock.rise_time)
    with of_arguments(options):
        found = UniversalCurve(shock.profile, rtol=options.rtol, longest=options.longest)
    if options.output:
        write_curve(found, options.output, mark=ratio)
        print(f"{options.output}: written", file=sys.stderr)
        return 0
    here: object = f"t0/T0 = {ratio:.6g}, beyond this curve (--longest)"
    if ratio <= found.longest_rise_time:
        here = found.answer(shock, scenario.chain)
    print(found, f"  this scenario  {here}", sep="\n")
    return 0
