"""A design in words and tables."""

from __future__ import annotations

import math
from collections.abc import Iterable

from shockwave.studies.design import Design, Option
from shockwave.studies.scaling_exponents import SIGNS
from shockwave.text import indent, notes, si, table


def design_text(found: Design) -> str:
    """The text that ``print`` shows."""
    target = found.target
    of = f" of {found.scenario}" if found.scenario else ""
    wanted = f"{target.name.replace('_', ' ')} {_si(target.value, target.unit, 6)}"
    ends = "" if found.between is None else " and ".join(_si(value, found.unit) for value in found.between)
    lines = [
        f"design{of}: {found.vary} for {wanted}{', between ' if ends else ''}{ends}",
        f"  reachable         {_at(found, found.least)} to {_at(found, found.most)}",
        f"  solutions         {len(found.solutions) or f'none: {found.why}'}",
    ]
    if found.nearest is not None:
        lines.append(f"  nearest           {_at(found, found.nearest)}")
    rows = found.solutions or ((found.nearest,) if found.nearest else ())
    against = "what is wanted" if found.solutions else "found"
    lines += [
        "",
        _table(_simulation(found, option) for option in rows),
        f"  (off: simulated against {against}; the powers are those with which the peak force goes)",
    ]
    if found.solutions:
        lines += ["", _table(_properties(found, option) for option in rows)]
    of_chain = "of the chain" if found.least.chain_mass is not None else "of a metre of chain"
    lines += [
        "",
        _table(_properties(found, option) for option in found.table),
        f"  (within: bound on the relative error of peak force and amplification; mass: of a granule, and {of_chain})",
    ]
    return "\n".join(lines + notes(found.warnings))


def why(found: Design) -> str:
    """Why there is no solution, in a sentence; empty where there is one."""
    if found.reachable:
        return ""
    wanted = _si(found.target.value, found.target.unit, 6)
    nearest = found.nearest.simulated if found.nearest else None
    if found.spanned and found.between is None:
        return f"no material meets {wanted}, which lies between the least and the greatest"
    if found.spanned and found.nearest and nearest:
        of = f"{_si(nearest.reached, found.target.unit)} at {_shown(found, found.nearest, 5)}"
        return (
            f"{wanted} is met by a chain without end alone; simulated as it is, the chain makes {of}"
            " (it is too short for this search: leave granules out, or simulate)"
        )
    low = found.target.value < found.least.reached
    end = found.least if low else found.most
    rest = "" if found.between is None or end.value in found.between else ", a turning point inside the interval"
    what = "the least" if low else "the most"
    return f"{wanted} is out of reach: {what} is {_at(found, end)}{rest}"


def _si(value: float, unit: str, digits: int = 5) -> str:
    """``value`` with an SI prefix, or bare where there is no unit."""
    return si(value, unit, digits) if unit else f"{value:.{digits}g}"


def _at(found: Design, option: Option) -> str:
    return f"{_si(option.reached, found.target.unit)} at {_shown(found, option, 5)}"


def _shown(found: Design, option: Option, digits: int) -> str:
    return option.value if isinstance(option.value, str) else _si(option.value, found.unit, digits)


def _value(found: Design, option: Option) -> str:
    """The value, with one digit more than are known; with eight in the trade-off, where it was chosen."""
    value, error = option.value, option.value_error
    if isinstance(value, str) or not value or not error:
        return _shown(found, option, 8)
    return _shown(found, option, min(max(2 + math.floor(math.log10(abs(value) / error)), 2), 8))


def _table(rows: Iterable[dict[str, str]]) -> str:
    header, *others = rows
    return indent(table(list(header), [list(row.values()) for row in (header, *others)]))


def _properties(found: Design, option: Option) -> dict[str, str]:
    columns = {_last(found): _value(found, option)}
    if found.target.name not in ("peak_force", "amplification", "speed", "width"):
        columns[found.target.name.replace("_", " ")] = _si(option.reached, found.target.unit, 6)
    chain = f"{si(1e3 * option.mass_per_length, 'g', 4)}/m"
    if option.chain_mass is not None:
        chain = si(1e3 * option.chain_mass, "g", 4)
    return columns | {
        "peak force": si(option.peak_force, "N", 6),
        "amplification": f"{option.amplification:.5g}",
        "within": f"{option.error:.0e}",
        "speed": si(option.speed, "m/s"),
        "width": si(option.width, "s"),
        "granule": si(1e3 * option.granule_mass, "g", 4),
        "chain": chain,
    }


def _simulation(found: Design, option: Option) -> dict[str, str]:
    """The simulation of an option, and the powers with which its peak force scales."""
    error = option.value_error
    columns = {
        _last(found): _value(found, option),
        "may be off": "-" if error is None else _si(float(f"{error:.0e}"), found.unit, 3),
        "simulated": "not known",
        "known to": "-",
        "off": "-",
    }
    known = option.simulated
    if known is not None:
        digits = min(max(8, 2 - math.floor(math.log10(known.error_estimate))), 15)
        against = found.target.value if found.solutions else option.reached
        columns["simulated"] = _si(known.reached, found.target.unit, digits)
        columns["known to"] = f"{known.error_estimate:.0e}"
        columns["off"] = f"{known.reached / against - 1:+.0e}"
    powers = {sign: f"{getattr(option.exponents, name):.3f}" for name, sign in SIGNS.items()}
    return columns | powers | {"each within": f"{option.exponents.error:.0e}"}


def _last(found: Design) -> str:
    return found.vary.rpartition(".")[2]
