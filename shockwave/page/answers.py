"""Both answers side by side: figures of the primary, and a table of all waves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.markup import Html, joined, percent, quantity, small, table, tag
from shockwave.measurement.result import MeasuredWave, SimulationResult
from shockwave.page.findings import Findings
from shockwave.page.words import count, digits_of, expected, known, settled
from shockwave.prediction.outcome import EjectionOutcome, Outcome

__all__ = ["answers"]

# Waves that a table lists; weaker ones are counted.
_MOST = 20
_NONE = Html("\N{EN DASH}")
_RELATIONS = {"less": "weaker", "equal": "about as strong", "greater": "stronger"}


def answers(found: Findings) -> Html:
    """Tables of both answers, as far as there are."""
    if found.predicted is None and found.simulated is None:
        return Html("")
    return joined((_figures(found), _published(found), _waves(found), _passages(found)))


# ---------------------------------------------------------------- figures


def _figures(found: Findings) -> Html:
    told = dict(_of_prediction(found.predicted)) if found.predicted is not None else {}
    seen = dict(_of_simulation(found.simulated)) if found.simulated is not None else {}
    if found.comparison is not None:
        told["error against the simulation"] = percent(found.comparison.error, 2)
        seen["primary against the shock"] = _RELATIONS[found.comparison.relation]
    order = [name for name in _ORDER if name in told or name in seen]
    rows = [(name, told.get(name, _NONE), seen.get(name, _NONE)) for name in order]
    return table(("", "predicted", "simulated"), rows)


_ORDER = (
    "peak force of the primary",
    "how well it is known",
    "error against the simulation",
    "amplification",
    "primary against the shock",
    "waves",
    "impulse of the shock",
    "momentum added by ejected granules",
    "momentum of granules thrown back",
    "granules thrown back",
    "granules that fly off the free end",
    "defect of momentum",
    "defect of energy",
    "steps",
    "force evaluations",
)


def _of_prediction(told: Outcome) -> Iterator[tuple[str, str]]:
    yield "peak force of the primary", quantity(told.peak_force, "N")
    yield "how well it is known", joined(("error ", expected(told)))
    yield "amplification", quantity(told.amplification, "")
    yield "primary against the shock", _RELATIONS[told.relation]
    yield "waves", str(len(told.waves))
    yield "impulse of the shock", quantity(told.applied_momentum, "N s")
    if isinstance(told, EjectionOutcome):
        yield "momentum added by ejected granules", quantity(told.added_momentum, "N s")


def _of_simulation(seen: SimulationResult) -> Iterator[tuple[str, str]]:
    digits = digits_of(seen.error_estimate)
    yield "peak force of the primary", quantity(seen.peak_force, "N", digits)
    yield "how well it is known", known(seen.error_estimate)
    yield "amplification", quantity(seen.amplification, "", digits)
    yield "impulse of the shock", quantity(seen.applied_momentum, "N s")
    yield "defect of momentum", small(seen.momentum_defect)
    yield "defect of energy", small(seen.energy_defect)
    if seen.options.waves == "train":
        train = seen.train
        yield "waves", count(seen)
        recoil = [quantity(train.recoil_momentum, "N s")]
        if train.recoil_error:
            recoil.append(quantity(train.recoil_error, "N s", 3))
        yield "momentum of granules thrown back", joined(recoil, " within ")
        yield "granules thrown back", str(seen.ejected_granules)
        if train.spall_velocities is not None:
            yield "granules that fly off the free end", str(len(train.spall_velocities))
    yield "steps", str(seen.cost.steps)
    yield "force evaluations", str(seen.cost.force_evaluations)


def _published(found: Findings) -> Html:
    printed = found.scenario.published
    if printed is None:
        return Html("")
    figures: list[str] = []
    if printed.relation is not None:
        figures.append(f"relation {printed.relation}")
    if printed.error is not None:
        figures.append(joined(("error ", percent(printed.error))))
    if printed.virtual_rise_time is not None:
        figures.append(joined(("virtual rise time ", quantity(printed.virtual_rise_time, "s"))))
    return tag("p", f"Printed in {printed.source}: ", joined(figures or ["no figures"], ", "), ".")


# ---------------------------------------------------------------- waves


def _waves(found: Findings) -> Html:
    told = found.predicted.waves if found.predicted is not None else ()
    seen = settled(found.simulated) if found.simulated is not None else []
    pairs = list(zip_longest(told, seen))
    forces = [(str(number), *_forces(*pair)) for number, pair in enumerate(pairs[:_MOST], start=1)]
    carried = [(str(number), *_carried(*pair)) for number, pair in enumerate(pairs[:_MOST], start=1)]
    return joined(
        (
            table(
                _FORCES,
                forces,
                "Peak forces of the waves: as predicted, the primary first; as simulated, the strongest first.",
            ),
            _left_out(len(pairs) - _MOST, found.simulated),
            table(_CARRIED, carried, _ABOUT),
        )
    )


_FORCES = ("wave", "predicted", "simulated", "rel. error", "prediction off by")
_CARRIED = ("wave", "momentum", "simulated", "energy", "simulated", "speed", "simulated", "contact", "arrival")
_ABOUT = (
    "What the waves carry, each as predicted and as simulated; the contact, counted from 0, and the time are those at"
    " which a simulated wave was read."
)


def _forces(told: SolitaryWave | None, seen: MeasuredWave | None) -> Sequence[str]:
    error = None if seen is None else seen.error_estimate
    return (
        _NONE if told is None else quantity(told.peak_force, "N"),
        _NONE if seen is None else quantity(seen.peak_force, "N", digits_of(error)),
        _NONE if error is None else small(error),
        _NONE if told is None or seen is None else percent(told.peak_force / seen.peak_force - 1),
    )


def _carried(told: SolitaryWave | None, seen: MeasuredWave | None) -> Sequence[str]:
    cells: list[str] = []
    for name, unit in (("momentum", "N s"), ("energy", "J"), ("speed", "m/s")):
        for wave in (told, seen):
            value = getattr(wave, name, None)
            cells.append(_NONE if value is None else quantity(value, unit, 4))
    read = (_NONE, _NONE) if seen is None else (str(seen.contact), quantity(seen.arrival_time, "s"))
    return (*cells, *read)


def _left_out(more: int, seen: SimulationResult | None) -> Html:
    sentences = []
    if more > 0:
        sentences.append(f"{more} more {'wave is' if more == 1 else 'waves are'} not listed.")
    unsettled = 0 if seen is None else len(seen.waves) - len(settled(seen))
    if unsettled:
        sentences.append(f"{unsettled} more had not settled when the simulation ended: their figures mean little.")
    if seen is not None:
        threshold = f"{seen.wave_threshold:g}"
        sentences.append(f"Simulated waves weaker than {threshold} of the primary are not counted.")
    return tag("p", " ".join(sentences), kind="note") if sentences else Html("")


def _passages(found: Findings) -> Html:
    if not found.passages:
        return Html("")
    rows = [
        (
            str(one.contact),
            quantity(one.arrival_time, "s", digits_of(one.error_estimate)),
            quantity(one.peak_force, "N", digits_of(one.error_estimate)),
            small(one.error_estimate),
            "exact wave" if one.exact else "integrated",
        )
        for one in found.passages
    ]
    caption = "The primary at the contacts that the scenario asks for."
    return table(("contact", "arrival", "peak force", "rel. error", "from"), rows, caption)
