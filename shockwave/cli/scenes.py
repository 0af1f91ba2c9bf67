"""Commands on scenario files: predict, simulate, compare, validate."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from shockwave.cli.output import DEBUG, internal, print_json, written
from shockwave.errors import Fault, InvalidValueError, PluginError, ScenarioError, ShockwaveError, UsageError
from shockwave.files import refuse_inputs

if TYPE_CHECKING:
    from shockwave.options import SimulateOptions
    from shockwave.scenario.scenario import Scenario

__all__ = ["compare", "curve", "loaded", "predict", "report", "simulate", "validate"]


def loaded(files: Sequence[str], remedy: str = "", output: str | None = None) -> tuple[list[Scenario], int]:
    """All scenarios and 0; or, after every fault of every file was told, the greatest exit status of them.

    One that stands for many is a fault here; ``remedy`` says what to do, or to run the sweep. ``output`` is the output
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


def _run(
    options: argparse.Namespace,
    one: Callable[[Scenario], Any],
    several: Callable[[list[Any]], str],
) -> int:
    """Do ``one`` for every scenario and print the results; a failure is told and does not stop the others."""
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
            # whatever the result leaves until it is looked at is looked at here
            document = result.to_dict()
        except ShockwaveError as error:
            print(f"{scenario.path}: {error}", file=sys.stderr)
            documents.append({"scenario": scenario.name, "error": str(error)})
            status = max(status, error.exit_code)
        except Exception as error:
            if os.environ.get(DEBUG):
                raise
            told = internal(error)
            print(f"{scenario.path}: {told}", file=sys.stderr)
            documents.append({"scenario": scenario.name, "error": told})
            status = max(status, 1)
        except KeyboardInterrupt:
            print(f"{scenario.path}: interrupted; what was done before follows", file=sys.stderr)
            status = 130
            break
        else:
            done.append(result)
            documents.append(document)
    if options.json:
        if documents:
            print_json(documents if len(options.files) > 1 else documents[0])
    elif len(options.files) == 1:
        for result in done:
            print(result)
    elif done:
        print(several(done))
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
    """The scenario's block ``simulate``, with what the command line puts in its place."""
    from attrs import evolve

    names = ("rtol", "step", "integrator", "backend", "contacts")
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if options.primary:
        given["waves"] = "primary"
    # a method named here has a use for its own settings, not for those of the one that it replaces
    if "integrator" in given:
        given = {"rtol": None, "step": None} | given
    return evolve(scenario.simulate, **given)


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
    for failure in found.failures:
        print(f"{options.file}: {failure}", file=sys.stderr)
    status = written(page(found), options.output, anew=False)
    return status or (1 if found.failures else 0)


def curve(options: argparse.Namespace) -> int:
    """The universal curve of a scenario's shape."""
    from shockwave.chain import Scales
    from shockwave.studies.curve import UniversalCurve, write
    from shockwave.studies.curve.output import checked

    if options.output:
        try:
            checked(options.output)
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
    write(found, options.output, mark=ratio)
    print(f"{options.output}: written", file=sys.stderr)
    return 0


def validate(options: argparse.Namespace) -> int:
    from shockwave.scenario.loader import load_scenario

    status, documents = 0, []
    for file in options.files:
        faults: tuple[Fault, ...] = ()
        try:
            load_scenario(file)
        except (ScenarioError, PluginError) as error:
            faults, status = error.faults or (Fault("", str(error)),), max(status, error.exit_code)
        except ShockwaveError as error:
            faults, status = (Fault("", str(error)),), max(status, error.exit_code)
        documents.append(
            {
                "file": file,
                "valid": not faults,
                "faults": [{"location": f.location, "path": f.path, "problem": f.problem} for f in faults],
            }
        )
        if not options.json:
            print(*(faults or [f"{file}: valid"]), sep="\n")
    if options.json:
        print_json(documents if len(documents) > 1 else documents[0])
    return status
