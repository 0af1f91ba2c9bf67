"""The text of a design: the answer with its accuracy, warnings, and at most ten rows."""

from __future__ import annotations

from collections.abc import Sequence

from shockwave.studies.design_result import Design, Option
from shockwave.studies.quantities import Quantity
from shockwave.studies.varied_scenes import kind_of
from shockwave.tables import evenly
from shockwave.text import facts, is_wide, limits, paragraph, strong, table

# Most rows of the table, unless all are wanted.
_MOST_ROWS = 10


def text_of_design(design: Design) -> str:
    """The answer, its warnings, what is reachable, and the table."""
    best = design.least is not None
    answer = _best_answer(design) if best else _answer(design)
    details = [] if best else [("reason", design.why), ("reachable", _reachable(design))]
    lines = [
        *map(strong, paragraph("", answer, 2)),
        *limits(_kinds(design.warnings)),
        *facts(pair for pair in [*(_required(design) if best else []), *details] if pair[1]),
    ]
    rows = [_row(design, option) for option in _shown_options(design)]
    if rows:
        spare = [name for name in reversed(rows[0]) if name not in (next(iter(rows[0])), "")]
        lines += ["", table(list(rows[0]), [list(row.values()) for row in rows], spare)]
    hidden = len(design.table) - len(rows)
    if rows and hidden > 0:
        lines.append(f"  ({hidden} more rows; --wide shows all)")
    return "\n".join(lines)


def _kinds(warnings: Sequence[str]) -> list[str]:
    """The first of the warnings that differ in numbers alone."""
    return list({kind_of(warning): warning for warning in reversed(warnings)}.values())[::-1]


def _shown_options(design: Design) -> list[Option]:
    """Options of the table: the solutions of a number first, then the trade-off or the ranking."""
    first = [] if design.is_ranked or design.least is not None else list(design.solutions)
    if is_wide():
        return [*first, *design.table]
    first = first[:_MOST_ROWS]
    left = min(_MOST_ROWS - len(first), len(design.table))
    chosen = range(left) if design.is_ranked else evenly(len(design.table), left).tolist() if left else []
    return [*first, *(design.table[index] for index in chosen)]


def _answer(design: Design) -> str:
    """The solutions of one parameter, or the nearest option."""
    target = design.requirements[0]
    label, options = target.quantity.label, design.solutions or tuple(filter(None, [design.nearest]))
    values = " or ".join(map(design.value_text, options))
    simulated = f"(simulated {', '.join(design.shown(option, target.quantity) for option in options)})"
    relation = f"of {target.bound[2:]}" if target.sign == "=" else target.bound
    wanted = f"{'an' if label.startswith(('a', 'e')) else 'a'} {label} {relation}"
    if design.intervals:
        (parameter,) = design.parameters
        ends = [[parameter.shown(end) for end in dict.fromkeys(both)] for both in design.intervals]
        spans = " or ".join(" to ".join(both) for both in ends)
        return f"{design.varied} {spans} gives {wanted}" + f" (limits {values}, {simulated[1:]}" * bool(
            design.solutions
        )
    if design.reachable:
        return f"{design.varied} {values} gives {wanted} {simulated}"
    return f"no {design.varied} gives {wanted}; nearest {values} {simulated}"


def _reachable(design: Design) -> str:
    """The range of the first required quantity."""
    quantity = design.requirements[0].quantity
    ends = (f"{design.shown(each, quantity)} at {design.value_text(each)}" for each in (design.lowest, design.highest))
    return " to ".join(ends)


def _best_answer(design: Design) -> str:
    option = design.best or design.nearest
    assert option is not None
    pairs = zip(design.parameters, option.values, strict=True)
    values = ", ".join(f"{each.name.removeprefix('chain.')} {each.shown(value)}" for each, value in pairs)
    quantity = next(each for each in design.quantities if each.name == design.least)
    shown = f"{quantity.label} {design.shown(option, quantity)} with {values}"
    return f"{design.scenario or 'design'}: {shown if design.best else f'{design.why}: {shown}'}"


def _required(design: Design) -> list[tuple[str, str]]:
    """What the answer reaches of each requirement, and what it took."""
    option = design.best or design.nearest
    assert option is not None
    reached = [
        (each.quantity.label, f"{design.shown(option, each.quantity)}, required {each.bound}")
        for each in design.requirements
    ]
    least = next(each.label for each in design.quantities if each.name == design.least)
    count = f"{len(design.tried)}, the answer verified at 1e-8"
    return [*reached, ("minimised", least), ("simulations", count)]


def _row(design: Design, option: Option) -> dict[str, str]:
    """The columns of an option."""
    numbers = len(design.parameters) == 1 and not design.is_ranked and design.least is None
    columns: dict[str, str] = {}
    for parameter, value in zip(design.parameters, option.values, strict=True):
        label = design.varied if len(design.parameters) == 1 else parameter.label
        label = parameter.name if label in columns else label
        shown, _, error = parameter.shown(value, option.value_error).partition(" +- ")
        columns |= {label: shown} | ({"+-": error or "-"} if numbers else {})
    columns |= {quantity.label: design.shown(option, quantity) for quantity in _shown_quantities(design)}
    if design.least is not None:
        columns[""] = "meets all" if option.violation <= 0 else f"misses by {option.violation:.1%}"
    return columns


def _shown_quantities(design: Design) -> list[Quantity]:
    """Quantities of the table; one that is neither required nor minimised is left out if it is the same in all rows."""
    stated = {design.least, *(each.quantity.name for each in design.requirements)}
    return [
        quantity
        for quantity in design.quantities
        if quantity.name in stated or len({option.quantities[quantity.name] for option in design.table}) > 1
    ]
