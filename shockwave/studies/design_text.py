"""The text of a design: the answer with its accuracy, warnings, and at most ten rows."""

from __future__ import annotations

from collections.abc import Iterable

from shockwave.base.result_tables import evenly
from shockwave.base.text import facts, is_wide, limits, paragraph, percent, strong, table
from shockwave.scene.force_limit import may_grow
from shockwave.studies.design_result import Design, Option

# Most rows of the table, unless all are wanted.
_MOST_ROWS = 10


def text_of_design(design: Design) -> str:
    """The answer, its warnings, what is reachable, and the table."""
    best = design.least is not None
    answer = _best_answer(design) if best else _answer(design)
    details = [] if best else [("reason", design.why), ("reachable", _reachable(design))]
    lines = [
        *map(strong, paragraph("", answer, 2)),
        *limits(design.warnings),
        *facts(pair for pair in [*(_requirement_facts(design) if best else []), *details] if pair[1]),
    ]
    options = [*_first_options(design), *design.table]
    rows = [_row(design, option) for option in _select_options(design)]
    if rows:
        spare = [name for name in reversed(rows[0]) if name not in (next(iter(rows[0])), "")]
        lines += ["", table(list(rows[0]), [list(row.values()) for row in rows], spare)]
    if len(rows) < len(options):
        lines.append(f"  ({len(options) - len(rows)} more rows; --wide shows all)")
    return "\n".join(lines)


def _first_options(design: Design) -> list[Option]:
    """Solutions that are not in the table."""
    return [] if design.is_ranked or design.least is not None else list(design.solutions)


def _select_options(design: Design) -> list[Option]:
    """Options of the printed table: the solutions of a number first, then the trade-off or the ranking."""
    first, others = _first_options(design), list(design.table)
    if not is_wide():
        first = first[:_MOST_ROWS]
        left = min(_MOST_ROWS - len(first), len(others))
        chosen = range(left) if design.is_ranked else evenly(len(others), left).tolist() if left else []
        others = [others[index] for index in chosen]
    return [*first, *others]


def _answer(design: Design) -> str:
    """The solutions of one parameter, or the nearest option."""
    target = design.requirements[0]
    label, options = target.quantity.label, design.solutions or tuple(filter(None, [design.nearest]))
    runs = _runs(design, options)
    values = " or ".join(_range_text(map(design.value_text, run)) for run in runs)
    reached = (sorted(run, key=lambda option: option.reached) for run in runs)
    figures = (_range_text(design.format(option, target.quantity) for option in run) for run in reached)
    simulated = f"(simulated {', '.join(figures)})"
    relation = f"of {target.bound[2:]}" if target.sign == "=" else target.bound
    within = " within the simulated time" * (target.quantity.unit == "N" and may_grow(design.warnings))
    wanted = f"{'an' if label.startswith(('a', 'e')) else 'a'} {label} {relation}{within}"
    if design.intervals:
        (parameter,) = design.parameters
        ends = [[parameter.format(end) for end in dict.fromkeys(both)] for both in design.intervals]
        spans = " or ".join(" to ".join(both) for both in ends)
        limits_of = f" (limits {values}, {simulated[1:]}" if design.solutions else ""
        return f"{design.varied} {spans} gives {wanted}{limits_of}"
    if design.reachable:
        return f"{design.varied} {values} gives {wanted} {simulated}"
    return f"no {design.varied} gives {wanted}; nearest {values} {simulated}"


def _runs(design: Design, options: Iterable[Option]) -> list[list[Option]]:
    """Options with consecutive whole numbers, three or more together; each of the others alone."""
    runs: list[list[Option]] = []
    for option in options:
        if design.parameters[0].whole and runs and option.value == float(runs[-1][-1].value) + 1:
            runs[-1].append(option)
        else:
            runs.append([option])
    return [part for run in runs for part in ([run] if len(run) > 2 else [[option] for option in run])]


def _range_text(texts: Iterable[str]) -> str:
    """The first and the last text, or the only one."""
    first, *_, last = [*texts] * 2
    return first if first == last else f"{first} to {last}"


def _reachable(design: Design) -> str:
    """The range of the first required quantity."""
    quantity = design.requirements[0].quantity
    ends = (f"{design.format(each, quantity)} at {design.value_text(each)}" for each in (design.lowest, design.highest))
    return " to ".join(ends)


def _best_answer(design: Design) -> str:
    option = design.best or design.nearest
    assert option is not None
    pairs = zip(design.parameters, option.values, strict=True)
    values = ", ".join(f"{each.name.removeprefix('chain.')} {each.format(value)}" for each, value in pairs)
    quantity = next(each for each in design.quantities if each.name == design.least)
    shown = f"{quantity.label} {design.format(option, quantity)} with {values}"
    return f"{design.scenario or 'design'}: {shown if design.best else f'{design.why}: {shown}'}"


def _requirement_facts(design: Design) -> list[tuple[str, str]]:
    """Values that the answer reaches for each requirement, and its cost."""
    option = design.best or design.nearest
    assert option is not None
    answers = [
        (each.quantity.label, f"{design.format(option, each.quantity)}, required {each.bound}")
        for each in design.requirements
    ]
    least = next(each.label for each in design.quantities if each.name == design.least)
    count = f"{len(design.tried)}, the answer verified at 1e-8"
    return [*answers, ("minimised", least), ("simulations", count)]


def _row(design: Design, option: Option) -> dict[str, str]:
    """The columns of an option."""
    numbers = len(design.parameters) == 1 and not design.is_ranked and design.least is None
    columns: dict[str, str] = {}
    for parameter, value in zip(design.parameters, option.values, strict=True):
        label = design.varied if len(design.parameters) == 1 else parameter.label
        label = parameter.name if label in columns else label
        shown, _, error = parameter.format(value, option.value_error).partition(" +- ")
        columns |= {label: shown} | ({"+-": error or "-"} if numbers else {})
    columns |= {quantity.label: design.format(option, quantity) for quantity in design.quantities}
    if design.least is not None:
        columns[""] = "meets all" if option.violation <= 0 else f"misses by {percent(option.violation)}"
    return columns
