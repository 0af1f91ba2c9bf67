"""Output of the commands: documents, files, one sentence for each error, and several results side by side."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from shockwave.errors import InvalidValueError, ShockwaveError, UsageError
from shockwave.files import write_file
from shockwave.text import notes, range_text, si, table

if TYPE_CHECKING:
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.studies.comparison import Comparison

#: The variable that shows where an internal error comes from.
_DEBUG = "SHOCKWAVE_DEBUG"


def failure(error: Exception) -> tuple[str, int]:
    """The message and the exit status for an error; with SHOCKWAVE_DEBUG, an internal error is raised instead."""
    if isinstance(error, ShockwaveError):
        return str(error), error.exit_code
    if os.environ.get(_DEBUG):
        raise error
    return f"internal error: {type(error).__name__}: {error} ({_DEBUG}=1 shows where; please report it)", 1


@contextmanager
def of_arguments(options: argparse.Namespace) -> Iterator[None]:
    """A fault of an argument is one of the call, not of a scenario."""
    try:
        yield
    except InvalidValueError as error:
        if not all(fault.path.partition(".")[0] in options for fault in error.faults):
            raise
        raise UsageError("\n".join(f"--{fault}" for fault in error.faults)) from None


def print_json(document: object) -> None:
    print(json.dumps(document, indent=2, allow_nan=False))


def print_result(found: Any, as_json: bool) -> None:
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)


def show_progress(text: str) -> None:
    """Print progress for people; a log does not want it."""
    if sys.stderr.isatty():
        print(text, file=sys.stderr)


def written(text: str, output: str | None, anew: bool = False) -> int:
    """Write ``text`` to the file ``output``, which ``anew`` must not exist, or to stdout."""
    if output:
        write_file(output, text, anew)
        print(f"{output}: written", file=sys.stderr)
    else:
        print(text, end="")
    return 0


# ---------------------------------------------------------------- several results, a row each, then their warnings

# Names of columns and their cells.
_Row = dict[str, str]

_LEGEND = """

relation: predicted / simulated{printed}; waves: predicted / simulated;
rel. error: of the simulated peak force, estimated;
error: of the predicted peak force against the simulated; expected error: range measured for such shocks"""


def outcome_table(outcomes: Sequence[Outcome]) -> str:
    """Several predictions."""
    warnings = [f"{outcome.scenario}: {warning}" for outcome in outcomes for warning in outcome.warnings]
    return _table([_outcome_row(outcome) for outcome in outcomes], warnings)


def simulation_table(results: Sequence[SimulationResult]) -> str:
    """Several simulations."""
    warnings = [f"{result.scenario}: {warning}" for result in results for warning in result.all_warnings]
    return _table([_simulation_row(result) for result in results], warnings)


def comparison_table(comparisons: Sequence[Comparison]) -> str:
    """Several comparisons, with printed figures where a scenario has them."""
    printed = any(both.published for both in comparisons)
    warnings = []
    for both in comparisons:
        own = dict.fromkeys((*both.predicted.warnings, *both.simulated.all_warnings))
        warnings += [f"{both.predicted.scenario}: {warning}" for warning in own]
    legend = _LEGEND.format(printed=" / printed" if printed else "")
    return _table([_comparison_row(both, printed) for both in comparisons], warnings, legend)


def _table(rows: Sequence[_Row], warnings: Sequence[str], legend: str = "") -> str:
    text = table(list(rows[0]), [list(row.values()) for row in rows])
    return "\n".join([text + legend, *notes(warnings)])


def _outcome_row(outcome: Outcome) -> _Row:
    return {
        "scenario": outcome.scenario or "-",
        "regime": outcome.regime,
        "relation": outcome.relation,
        "peak force": si(outcome.peak_force, "N"),
        "expected error": range_text(outcome.expected_error),
        "waves": str(len(outcome.waves)),
        "conditions (3)": _conditions(outcome),
    }


def _simulation_row(result: SimulationResult) -> _Row:
    primary_alone = result.options.waves == "primary"
    return {
        "scenario": result.scenario or "-",
        "peak force": si(result.peak_force, "N", 8),
        "rel. error": f"{result.error_estimate:.0e}",
        "amplification": f"{result.amplification:.8g}",
        "waves": _wave_count(result),
        "ejected": "-" if primary_alone else str(result.ejected_granules),
        "momentum defect": f"{result.momentum_defect:.0e}",
    }


def _comparison_row(both: Comparison, with_printed: bool) -> _Row:
    predicted = both.predicted
    simulated = both.simulated
    published = both.published
    relation = f"{predicted.relation} / {both.relation}"
    row = {
        "scenario": predicted.scenario or "-",
        "regime": predicted.regime,
        "relation": relation,
        "predicted": si(predicted.peak_force, "N"),
        "simulated": si(simulated.peak_force, "N", 8),
        "rel. error": f"{simulated.error_estimate:.0e}",
        "error": f"{both.error:+.2%}",
        "expected error": range_text(predicted.expected_error),
        "virtual t0": _virtual_rise_time(predicted),
        "waves": f"{len(predicted.waves)} / {_wave_count(simulated)}",
        "conditions (3)": _conditions(predicted),
    }
    if with_printed:
        error = published and published.error
        row["relation"] = f"{relation} / {(published and published.relation) or '-'}"
        row["printed error"] = "-" if error is None else f"{error:.1%}"
        row["printed t0"] = _virtual_rise_time(published)
    return row


def _wave_count(result: SimulationResult) -> str:
    """The number of settled waves; a plus stands for more that had not settled."""
    settled = sum(wave.error_estimate is not None for wave in result.waves)
    return f"{settled}{'+' if settled < len(result.waves) else ''}"


def _conditions(outcome: Outcome) -> str:
    broken = [f"{c.statement} fails by {-c.margin:.3g}" for c in outcome.conditions if not c.holds]
    return "; ".join(broken) or "hold"


def _virtual_rise_time(owner: object) -> str:
    time = getattr(owner, "virtual_rise_time", None)
    return "-" if time is None else si(time, "s")
