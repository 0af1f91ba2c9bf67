"""A design in words and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from shockwave.studies.design import Design, Option
from shockwave.studies.scaling_exponents import SIGNS
from shockwave.text import indent, notes, si, table

__all__ = ["design_text", "shown", "why"]


def design_text(found: Design) -> str:
    """What ``print`` shows."""
    target = found.target
    of = f" of {found.scenario}" if found.scenario else ""
    lines = [
        f"design{of}: {found.vary} for {_words(target.name)} {si_of(target.value, target.unit, 6)}{_where(found)}",
        f"  reachable         {_at(found, found.least)} to {_at(found, found.most)}",
    ]
    lines.append(f"  solutions         {len(found.solutions) or f'none: {found.why}'}")
    if found.nearest is not None:
        lines.append(f"  nearest           {_at(found, found.nearest)}")
    rows = found.solutions or ((found.nearest,) if found.nearest else ())
    lines += ["", indent(_verified(found, rows))]
    against = "what is wanted" if found.solutions else "found"
    lines.append(f"  (off: simulated against {against}; the powers are those with which the peak force goes)")
    if found.solutions:
        lines += ["", indent(_table(found, rows))]
    lines += ["", indent(_table(found, found.table))]
    lines.append(f"  (within: bound on the relative error of peak force and amplification; {_mass(found)})")
    return "\n".join(lines + notes(found.warnings))


def why(found: Design) -> str:
    """Why there is no solution, in a sentence; empty where there is one."""
    if found.reachable:
        return ""
    wanted = si_of(found.target.value, found.target.unit, 6)
    nearest = found.nearest.simulated if found.nearest else None
    if found.spanned and found.between is None:
        return f"no material meets {wanted}, which lies between the least and the greatest"
    if found.spanned and found.nearest and nearest:
        of = f"{si_of(nearest.reached, found.target.unit)} at {shown(found, found.nearest, 5)}"
        return (
            f"{wanted} is met by a chain without end alone; simulated as it is, the chain makes {of}"
            " (it is too short for this search: leave granules out, or simulate)"
        )
    low = found.target.value < found.least.reached
    end = found.least if low else found.most
    rest = "" if found.between is None or end.value in found.between else ", a turning point inside the interval"
    what = "the least" if low else "the most"
    return f"{wanted} is out of reach: {what} is {_at(found, end)}{rest}"


def si_of(value: float, unit: str, digits: int = 5) -> str:
    """``value`` with an SI prefix, or bare where there is no unit."""
    return si(value, unit, digits) if unit else f"{value:.{digits}g}"


def shown(found: Design, option: Option, digits: int = 6) -> str:
    """What was varied."""
    return option.value if isinstance(option.value, str) else si_of(option.value, found.unit, digits)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _where(found: Design) -> str:
    if found.between is None:
        return ""
    low, high = (si_of(value, found.unit) for value in found.between)
    return f", between {low} and {high}"


def _at(found: Design, option: Option) -> str:
    return f"{si_of(option.reached, found.target.unit)} at {shown(found, option, 5)}"


def _mass(found: Design) -> str:
    known = found.least.chain_mass is not None
    return "mass: of a granule, and of the chain" if known else "mass: of a granule, and of a metre of chain"


def _table(found: Design, rows: Sequence[Option]) -> str:
    target = found.target
    own = [] if target.name in ("peak_force", "amplification", "speed", "width") else [_words(target.name)]
    header = (found.vary.rpartition(".")[2], *own, "peak force", "amplification", "within", "speed", "width")
    return table((*header, "granule", "chain"), (tuple(_row(found, option, bool(own))) for option in rows))


def _value(found: Design, option: Option) -> str:
    """What was varied, with one digit more than are known; with eight in the trade-off, where it was chosen."""
    value, error = option.value, option.value_error
    if isinstance(value, str) or not value or not error:
        return shown(found, option, 8)
    return shown(found, option, min(max(2 + math.floor(math.log10(abs(value) / error)), 2), 8))


def _row(found: Design, option: Option, own: bool) -> Iterator[str]:
    yield _value(found, option)
    if own:
        yield si_of(option.reached, found.target.unit, 6)
    yield si(option.peak_force, "N", 6)
    yield f"{option.amplification:.5g}"
    yield f"{option.error:.0e}"
    yield si(option.speed, "m/s")
    yield si(option.width, "s")
    yield si(1e3 * option.granule_mass, "g", 4)
    if option.chain_mass is not None:
        yield si(1e3 * option.chain_mass, "g", 4)
    else:
        yield f"{si(1e3 * option.mass_per_length, 'g', 4)}/m"


def _verified(found: Design, rows: Sequence[Option]) -> str:
    """What simulations say of the rows, and with which powers their peak forces go."""
    header = (found.vary.rpartition(".")[2], "may be off", "simulated", "known to", "off")
    return table((*header, *SIGNS.values(), "each within"), (tuple(_simulated(found, option)) for option in rows))


def _simulated(found: Design, option: Option) -> Iterator[str]:
    error = option.value_error
    yield _value(found, option)
    yield "-" if error is None else f"{si_of(float(f'{error:.0e}'), found.unit, 3)}"
    known = option.simulated
    if known is None:
        yield from ("not known", "-", "-")
    else:
        digits = min(max(8, 2 - math.floor(math.log10(known.error_estimate))), 15)
        yield si_of(known.reached, found.target.unit, digits)
        yield f"{known.error_estimate:.0e}"
        yield f"{known.reached / (found.target.value if found.solutions else option.reached) - 1:+.0e}"
    for name in SIGNS:
        yield f"{getattr(option.exponents, name):.3f}"
    yield f"{option.exponents.error:.0e}"
