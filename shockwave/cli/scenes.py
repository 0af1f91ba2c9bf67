"""Commands on scenario files: predict, simulate, compare, validate, report, curve."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from shockwave.cli.output import failure, print_json, written
from shockwave.errors import Fault, InvalidValueError, ShockwaveError, UsageError
from shockwave.files import refuse_inputs

if TYPE_CHECKING:
    from shockwave.options import SimulateOptions
    from shockwave.scenario.scenario import Scenario


def loaded(files: Sequence[str], remedy: str = "", output: str | None = None) -> tuple[list[Scenario], int]:
    """All scenarios and 0; or, after all errors of all files were reported, the greatest exit status of them.

    One that stands for many is an error here; ``remedy`` says what to do, or to run the sweep. ``output`` is the output
    file, which must not be one of the input files.
    """
    from shockwave.scenario.loader import load_scenario

    scenarios: list[Scenario] = []
    status = 0
    for file in files:
        try:
            scenario = load_scenario(file)
            if scenario.sweep is not None:
                instead = remedy or f"run `shockwave sweep {file}`"
                raise UsageError(f"{file}: must be a single scene (got a sweep of {len(scenario.sweep)}; {instead})")
            scenarios.append(scenario)
        except ShockwaveError as error:
            print(error, file=sys.stderr)
            status = max(status, error.exit_code)
    if output and not status:
        refuse_inputs(output, (file for scenario in scenarios for file in scenario.files))
    return scenarios, status


def _run(options: argparse.Namespace, one: Callable[[Scenario], Any], several: Callable[[list[Any]], str]) -> int:
    """Do ``one`` for every scenario and print the results; a failure is reported and does not stop the others."""
    scenarios, status = loaded(options.files)
    if status:
        return status
    done: list[Any] = []
    documents: list[dict[str, Any]] = []
    for number, scenario in enumerate(scenarios, start=1):
        if sys.stderr.isatty():
            print(f"{number} of {len(scenarios)}: {scenario.name}", file=sys.stderr)
        try:
            result = one(scenario)
            # parts of a result that are computed when they are used may fail, too
            documents.append(result.to_dict())
            done.append(result)
        except KeyboardInterrupt:
            print(f"{scenario.path}: interrupted; what was done before follows", file=sys.stderr)
            status = 130
            break
        except Exception as error:
            text, code = failure(error)
            print(f"{scenario.path}: {text}", file=sys.stderr)
            documents.append({"scenario": scenario.name, "error": text})
            status = max(status, code)
    if options.json:
        if documents:
            print_json(documents if len(options.files) > 1 else documents[0])
    elif done:
        print(several(done) if len(options.files) > 1 else done[0])
    return status


def predict(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.cli.result_tables import outcome_table

    def one(scenario: Scenario) -> Any:
        return evolve(scenario.predictor.predict(scenario.shock, scenario.chain), scenario=scenario.name)

    return _run(options, one, outcome_table)


def simulate(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.cli.result_tables import simulation_table
    from shockwave.measurement.simulate import simulate_with

    def one(scenario: Scenario) -> Any:
        result = simulate_with(_settings(options, scenario), scenario.shock, scenario.chain)
        return evolve(result, scenario=scenario.name)

    return _run(options, one, simulation_table)


def compare(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.cli.result_tables import comparison_table
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
    from attrs import evolve

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

    status, documents = 0, []
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

    scenarios, status = loaded([options.file], output=options.output)
    if status:
        return status
    figure()  # what the page needs is looked for before anything is computed
    found = findings(scenarios[0])
    for failed in found.failures:
        print(f"{options.file}: {failed}", file=sys.stderr)
    status = written(page(found), options.output, anew=False)
    return status or (1 if found.failures else 0)


def curve(options: argparse.Namespace) -> int:
    """The universal curve of a scenario's shape."""
    from shockwave.chain import Scales
    from shockwave.studies.study_pictures import CURVE_FILES, checked, write_curve
    from shockwave.studies.universal_curve import UniversalCurve

    if options.output:
        try:
            checked(options.output, CURVE_FILES)
        except InvalidValueError as error:
            raise UsageError(f"--output: {error.faults[0].problem}") from None
    scenarios, status = loaded([options.file], output=options.output)
    if status:
        return status
    shock, chain = scenarios[0].shock, scenarios[0].chain
    ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
    found = UniversalCurve(shock.profile, rtol=options.rtol, longest=options.longest)
    if not options.output:
        longer = f"t0/T0 = {ratio:.6g}, beyond this curve (--longest)"
        here = found.answer(shock, chain) if ratio <= found.longest_rise_time else longer
        print(found, f"  this scenario  {here}", sep="\n")
        return 0
    write_curve(found, options.output, mark=ratio)
    print(f"{options.output}: written", file=sys.stderr)
    return 0
