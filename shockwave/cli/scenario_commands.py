"""Commands on scenario files: predict, simulate, compare, validate, report; tables of several results."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shockwave import answers
from shockwave.base.errors import Fault, FileAccessError, InvalidValueError, NumericalError, ShockwaveError, UsageError
from shockwave.base.progress import track
from shockwave.base.quantities import FORCES, LEADING_WAVE, WALL, Quantity
from shockwave.base.result import VERSION
from shockwave.base.text import alarm, error_text, limits, notes, paragraph, percent, si, table
from shockwave.cli.output import PICTURES, TABLES, announce_file, check_output, failure, json_text, write_output
from shockwave.cli.scenario_files import label_file, load_scenarios, load_with_changes, name_of, stem_of
from shockwave.prediction.outcome_text import SHOWN_ERROR
from shockwave.scenario.scenario import Scenario
from shockwave.scene.plausibility import unusual

if TYPE_CHECKING:
    from shockwave.prediction.outcome import Outcome
    from shockwave.prediction.section4_outcome import Section4Outcome
    from shockwave.simulation.simulation_result import Simulation
    from shockwave.studies.comparison import Comparison

_PEAK, _AMPLIFICATION = LEADING_WAVE[:2]
_GREATEST = FORCES[0]
# Line that every page of `shockwave report` contains.
_GENERATOR = b'<meta name="generator" content="shockwave">'
# Names of columns and their cells.
_Row = dict[str, str]


def _run(options: Namespace, answer: Callable[[Scenario], Any], row: Callable[[Any], _Row], legend: str = "") -> int:
    """Get the ``answer`` for every scenario and print the results; a failure is reported and does not stop the others.

    A single result is printed in full, several in a table with a ``row`` each; after an interrupt, those so far.
    """
    status = 0
    done = []
    shown: list[Any] = []
    problems = []
    scenarios = load_scenarios(options)
    single = len(scenarios) == 1
    for scenario in scenarios if single else track(options.command.partition(":")[2], scenarios):
        try:
            result = answer(scenario)
            # parts of a result that are computed when they are used may fail, too
            shown.append(result.to_dict() if options.json else str(result) if single else row(result))
            done.append(result)
            # a prediction without an answer of the simulation
            if getattr(result, "method", "") == "simulation" and result.reason:
                status = max(status, NumericalError.exit_code)
        except Exception as error:
            text, code = failure(scenario.scene.locate_error(error))
            file = name_of(scenario)
            problems.append(text if text.startswith(f"{file}:") else f"{file}: {text}")
            warnings = getattr(error, "__notes__", [])
            problems += [line for warning in warnings for line in paragraph("  ! ", warning, 4)]
            if options.json:
                more = {"warnings": warnings} if warnings else {}
                shown.append({**VERSION, "scenario": scenario.name, "error": text, **more})
            status = max(status, code)
        except KeyboardInterrupt:
            problems.append(f"{name_of(scenario)}: interrupted")
            status = 130
            break
    for problem in problems:  # not earlier, for they would stand in the line of the progress
        print(problem, file=sys.stderr)
    if options.json and shown:
        print(json_text(shown[0] if single else shown))
    elif shown:
        print(shown[0] if single else _table(shown, done, legend))
    return status


def predict(options: Namespace) -> int:
    return _run(options, answers.predict, _outcome_row, _OUTCOME_LEGEND)


def simulate(options: Namespace) -> int:
    for file in options.record:
        check_output(file, *TABLES, *PICTURES, option="--record")
    if options.record and len(options.files) > 1:
        raise UsageError(f"--record: must be given with one scenario (got {len(options.files)})")

    def answer(scenario: Scenario) -> Any:
        result = answers.simulate(scenario)
        for file in options.record:
            _write_histories(result, file)
        return result

    return _run(options, answer, _simulation_row)


def _write_histories(result: Simulation, file: str) -> None:
    """Write the histories of a result as a table or, with a row for each unit of its sensors, as a picture."""
    if not result.options.is_recorded:
        hint = "such as --set 'simulate.sensors=[wall]'"
        raise InvalidValueError.of("simulate.sensors", f"must be given for --record (got nothing; {hint})")
    recording = result.recording
    if recording is None:
        raise NumericalError(result.warnings[-1])
    with announce_file(file):
        if file.lower().endswith(TABLES):
            recording.write(file)
            return
        from shockwave import pictures

        units = list(dict.fromkeys(each.unit for each in recording.sensors))
        drawn, places = pictures.figure(max(len(units), 1), size="page")
        for ax, unit in zip(places, units, strict=False):
            pictures.sensors(result, unit, ax=ax)
        if not units:
            result.plot(ax=places[0])
        pictures.save(drawn, file)


def compare(options: Namespace) -> int:
    return _run(options, answers.compare, _comparison_row, _LEGEND)


def validate(options: Namespace) -> int:
    status = 0
    documents = []
    for file in options.files:
        faults: Sequence[Fault] = ()
        warnings: list[str] = []
        try:
            scenario = load_with_changes(file, options, len(options.files) > 1)
            if scenario.sweep is not None:
                from shockwave.sweep.point_evaluation import Points  # most scenarios have no sweep

                Points(scenario)
            scene = scenario.scene
            warnings = [str(scene.place_fault(fault)) for fault in unusual(scene.excitation, scene.chain)]
        except ShockwaveError as error:
            faults = error.faults
            status = max(status, error.exit_code)
        documents.append(
            {
                **VERSION,
                "file": label_file(file),
                "valid": not faults,
                "faults": [fault.to_dict() for fault in faults],
                "warnings": warnings,
            }
        )
        if not options.json:
            print("\n".join(map(str, faults)) or f"{label_file(file)}: valid", *limits(warnings), sep="\n")
    if options.json:
        print(json_text(documents if len(documents) > 1 else documents[0]))
    return status


def report(options: Namespace) -> int:
    """One page on a scenario."""
    from shockwave.pictures import figure
    from shockwave.report import compute_results, render_page

    output = options.output or f"{stem_of(options.file)}.html"
    if not options.output and os.path.exists(output) and _GENERATOR not in Path(output).read_bytes():
        remedy = "give a name with --output"
        raise FileAccessError(f"{output}: must be a report to be replaced (got another kind of file; {remedy})")
    if Path(output).suffix:
        check_output(output, ".html", ".htm", hint="; print this page to a PDF in a browser")
    (scenario,) = load_scenarios(options, output=output)
    figure()  # fails early without matplotlib
    results = compute_results(scenario)
    for failed in results.failures:
        print(f"{name_of(scenario)}: {failed}", file=sys.stderr)
    write_output(render_page(results), output)
    return results.exit_code


# ---------------------------------------------------------------- tables of several results, then their warnings

# Columns that a narrow screen leaves out, the last named first.
_SPARE = (
    *("(3)", "relation", "regime", "ejected", "waves", "published error", "virtual t0"),
    *("published t0", "amplification", "wall impulse", "added momentum", "simulation error"),
)
_FAILS = "FAIL"
_NO_ANSWER = "no answer"
_OUTCOME_LEGEND = (
    "error: estimated relative error of the force; section-4 error: relative difference from the simulated force"
)
_LEGEND = """\
error: relative error of section 4 with respect to the simulation; added momentum: relative error of the momentum \
added by ejection; relation, waves: predicted / simulated (/ published)"""


def _table(rows: Sequence[_Row], results: Sequence[Any], legend: str) -> str:
    header = list(dict.fromkeys(name for row in sorted(rows, key=len, reverse=True) for name in row))
    cells = [[row.get(name, "-") for name in header] for row in rows]
    failed = any(_FAILS in cell for row in rows for cell in row.values())
    spare = [name for name in _SPARE if name in header and not (failed and name == "(3)")]
    limiting, others = [], []
    for row, result in zip(rows, results, strict=True):
        if _NO_ANSWER in row.values():
            limiting.append(f"{result.scenario}: {_NO_ANSWER}: {result.reason}")
        remarks = result.remarks()
        limiting += [f"{result.scenario}: {warning}" for warning in remarks["warnings"]]
        others += [f"{result.scenario}: {note}" for note in remarks["notes"]]
    lines = [table(header, cells, spare, margin=0), *limits(dict.fromkeys(limiting))]
    if legend:
        lines += ["", *paragraph("", legend)]
    return "\n".join([*lines, *notes(dict.fromkeys(others))])


def _outcome_row(outcome: Outcome) -> _Row:
    paper = outcome.section4
    row = {"scenario": outcome.scenario or "-", **_verdict_cell(outcome), **_force_cells(outcome)}
    row["relation"] = outcome.relation or "-"
    if paper is not None and outcome.simulation is not None:
        row["section-4"] = si(paper.peak_force, "N", error=SHOWN_ERROR)
        row["section-4 error"] = error_text(paper.error)
    if paper is not None:
        row |= {"(3)": _conditions(paper), "regime": paper.regime}
    return row


def _force_cells(outcome: Outcome) -> _Row:
    """The first force of an outcome with its error."""
    if outcome.simulation is None:
        return _error_cells(_PEAK, (outcome.peak_force, SHOWN_ERROR), known=False)
    figures = ((quantity, quantity.figures(outcome.simulated)) for quantity in (WALL[0], _PEAK, _GREATEST))
    cells = (_error_cells(quantity, both) for quantity, both in figures if both is not None)
    return next(cells, {_PEAK.label: _NO_ANSWER})


def _error_cells(quantity: Quantity, figures: tuple[float, float] | None, known: bool = True) -> _Row:
    """A force with the estimate of its relative error."""
    force, error = figures or (0.0, 1.0)
    shown = f"{error:.0e}" if known and force and error < 1 else "not known"
    return {quantity.label: si(force, quantity.unit, error=error), "error": shown}


def _cells(result: Simulation, *quantities: Quantity) -> _Row:
    """Quantities of a simulation, of those that it has, with the digits that their errors support."""
    figures = ((quantity, quantity.figures(result)) for quantity in quantities)
    return {quantity.label: si(both[0], quantity.unit, error=both[1]) for quantity, both in figures if both is not None}


def _simulation_row(result: Simulation) -> _Row:
    row = {"scenario": result.scenario or "-", **_verdict_cell(result)}
    if result.peak_force is None:
        return row | _error_cells(_GREATEST, _GREATEST.figures(result)) | _cells(result, *WALL)
    count = str(result.ejected_granules) if result.options.waves == "train" else "-"
    row |= _greatest_cell(result) | _error_cells(_PEAK, _PEAK.figures(result)) | _cells(result, _AMPLIFICATION)
    return row | {"waves": _wave_count(result), "ejected": count}


def _comparison_row(both: Comparison) -> _Row:
    simulated, published, errors = both.simulated, both.published, both.errors
    paper = None if both.predicted is None else both.predicted.section4
    if paper is None or errors.peak_force is None:
        row = _simulation_row(simulated)
        row["simulation error"] = row.pop("error")
        return row
    row = {
        "scenario": both.scenario or "-",
        **_verdict_cell(both),
        **_greatest_cell(simulated),
        "simulated": si(simulated.peak_force, "N", error=simulated.error_estimate),
        "section-4": si(paper.peak_force, "N", error=SHOWN_ERROR),
        "error": error_text(errors.peak_force),
        "(3)": _conditions(paper),
        "regime": paper.regime,
        "relation": f"{paper.relation} / {both.relation}",
        "waves": f"{len(paper.waves)} / {_wave_count(simulated)}",
        "added momentum": error_text(errors.added_momentum),
        "simulation error": f"{simulated.error_estimate:.0e}",
        "virtual t0": _virtual_rise_time(paper, SHOWN_ERROR),
    }
    if published:
        row["relation"] += f" / {published.relation or '-'}"
        row["published error"] = "-" if published.error is None else percent(published.error)
        row["published t0"] = _virtual_rise_time(published, 1e-3)
    return row


def _greatest_cell(result: Simulation) -> _Row:
    """The greatest contact force of a finite chain if it exceeds the leading wave."""
    from shockwave.simulation.simulation_text import greatest_text

    text = greatest_text(result)
    return {"greatest force": text.partition(" at ")[0]} if text else {}


def _verdict_cell(result: Any) -> _Row:
    """The decision on the limit, if there is one."""
    if result.verdict is None:
        return {}
    decision = result.verdict.decision
    return {"verdict": decision if decision == "below" else alarm(decision)}


def _wave_count(result: Simulation) -> str:
    """The number of settled waves; a plus stands for more that had not settled."""
    settled = sum(wave.error_estimate is not None for wave in result.waves)
    return f"{settled}{'+' if settled < len(result.waves) else ''}"


def _conditions(paper: Section4Outcome) -> str:
    return "hold" if paper.holds else alarm(_FAILS)


def _virtual_rise_time(owner: object, error: float) -> str:
    time = getattr(owner, "virtual_rise_time", None)
    return "-" if time is None else si(time, "s", error=error)
