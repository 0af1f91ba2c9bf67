"""Predictions of many shocks in columns, such as those of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from attrs import evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.yielding import Yielding, yielding_of
from shockwave.plausibility import unusual_warnings
from shockwave.prediction.expected_error import (
    FIRST_CONTACTS,
    expected_errors,
    failed_conditions,
    in_chain,
    unbounded,
    warning_of,
)
from shockwave.prediction.model_interface import Peaks, ScaledShocks
from shockwave.profiles.conditions import hold
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray


@frozen(eq=False)
class PredictionColumns:
    """Results of the shocks at ``places``: lists of numbers and texts by name, with None where there is no value.

    ``failures`` has the error for each of the other shocks.
    """

    places: list[int]
    values: dict[str, list[Any]]
    failures: dict[int, str]


def prediction_columns(
    found: Peaks, together: ScaledShocks, shocks: Sequence[Shock], chains: Sequence[Chain]
) -> PredictionColumns:
    """Columns of the attributes of outcomes, from the answers ``found`` of a complete model; see `Outcome`."""
    scaled, places, units = together.shocks, together.places, together.units
    estimates, errors = expected_errors(found, scaled)
    failures = together.failures | {places[index]: reason for index, reason in found.failures.items()}
    valid = (
        hold(scaled.areas, [profile.duration_ratio for profile in scaled.profiles])[scaled.shapes] | found.states_error
    )
    failed = cache(lambda shape: failed_conditions(scaled.shock(int(np.argmax(scaled.shapes == shape)))))
    notes: list[str | None] = []
    yields: dict[int, Yielding | None] = {}  # of a force of 1 N, by the identity of the chain
    scenes = zip(places, scaled.shapes.tolist(), valid.tolist(), np.isnan(estimates[:, 0]).tolist(), strict=True)
    for own, (place, shape, holds, unknown) in enumerate(scenes):
        shock, chain = shocks[place], chains[place]
        said = [*shock.profile.notes, *unusual_warnings(shock, chain)]
        if not holds:
            said.append(failed(shape))
        said += found.notes.get(own, ())
        problem = ""
        if chain.count is not None:
            problem, estimates[own], errors[own] = in_chain(chain, scaled.shock(own), estimates[own], errors[own])
        if unknown and not problem:
            problem = unbounded(scaled.shock(own), shock.peak_force)
        if problem:
            said.append(warning_of(problem))
            estimates[own], errors[own] = np.nan, (-np.inf, np.inf)
        if chain.count is not None:
            said.append(FIRST_CONTACTS)
        if id(chain) not in yields:
            yields[id(chain)] = yielding_of(chain, 1.0)
        if (unit := yields[id(chain)]) is not None:
            amplification = max(found.amplification[own], 1.0) if problem or unknown else estimates[own, 0]
            force = float(amplification) * shock.peak_force * chain.contact_share
            said += evolve(unit, peak_ratio=force * unit.peak_ratio).warnings
        notes.append(" ".join(dict.fromkeys(said)) or None)
    forces, rise_times, times, momenta = (
        np.array(
            [
                (shocks[place].peak_force, shocks[place].rise_time, unit.time, unit.momentum)
                for place, unit in zip(places, units, strict=True)
            ]
        )
        .reshape(-1, 4)
        .T
    )
    areas, ratios = (
        np.array(each, dtype=float)[scaled.shapes]
        for each in ([each.total for each in scaled.areas], [profile.duration_ratio for profile in scaled.profiles])
    )
    amplification = estimates[:, 0].copy()
    forces = forces * np.array([chains[place].contact_share for place in places])
    peak, low, high = (estimates * forces[:, None]).T
    known = np.isfinite(errors[:, 0])
    numbers = {
        "peak_force": found.amplification * forces,
        "amplification": found.amplification,
        "expected_error_low": np.where(known, errors[:, 0], np.nan),
        "expected_error_high": np.where(known, errors[:, 1], np.nan),
        "estimate": peak,
        "estimate_low": low,
        "estimate_high": high,
        "estimate_amplification": amplification,
        "applied_momentum": scaled.rise_times * areas * momenta,
        "virtual_rise_time": found.virtual_rise_time * times,
        "added_momentum": found.added_momentum * momenta,
        "scaled_rise_time": rise_times / times,
        "scaled_duration": ratios * rise_times / times,
    }
    values = {name: _plain(column) for name, column in numbers.items()}
    values |= {name: getattr(found, name).tolist() for name in ("regime", "relation", "waves")} | {"notes": notes}
    return PredictionColumns(places, values, failures)


def _plain(column: FloatArray) -> list[Any]:
    """Numbers of a column, with None in place of those that are not finite."""
    numbers = column.astype(object)
    numbers[~np.isfinite(column)] = None
    return list(numbers)
