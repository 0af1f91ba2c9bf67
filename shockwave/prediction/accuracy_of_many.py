"""Estimates and expected errors of many predictions, computed together."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from attrs import frozen

from shockwave.chain.chain import Chain
from shockwave.fields import listed
from shockwave.plausibility import unusual_warnings
from shockwave.prediction.expected_error import expected_errors, in_chain, warning_of
from shockwave.prediction.model_interface import Peaks, ScaledAnswer, ScaledShock, Settings, Shocks, one_by_one
from shockwave.prediction.outcome import Accuracy
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray

# Most shocks that a warning on several of them names.
_MOST_NUMBERED = 8


@frozen(eq=False, slots=False)
class Ranges:
    """Estimated amplifications with the ends of their ranges, and ranges of the relative errors, of several shocks.

    They are computed together, when the first of them is needed.
    """

    scaled: list[ScaledShock]
    answers: list[ScaledAnswer]
    settings: Settings

    def __call__(self, index: int) -> list[float]:
        return self._together[index] if self._together else self._of(slice(index, index + 1))[0]

    @cached_property
    def _together(self) -> list[list[float]]:
        """All ranges; empty if those of one shock cannot be computed."""
        try:
            return self._of(slice(None))
        except Exception:
            return []

    def _of(self, part: slice) -> list[list[float]]:
        shocks, left = Shocks.of(self.scaled[part]), iter(self.answers[part])
        found = one_by_one(lambda *_: next(left), shocks, self.settings)
        ranges: list[list[float]] = np.hstack(expected_errors(found, shocks)).tolist()
        return ranges


def accuracies(
    shocks: Sequence[Shock], chains: Sequence[Chain], scaled: Shocks, found: Peaks, places: Sequence[int]
) -> Accuracy[FloatArray, FloatArray]:
    """Accuracies of predictions of the shocks at ``places``, which are ``scaled``, by the answers ``found``."""
    estimates, errors = np.full((len(shocks), 3), np.nan), np.full((len(shocks), 2), (-np.inf, np.inf))
    estimates[places], errors[places] = expected_errors(found, scaled)
    notes: dict[str, list[int]] = {}
    for own, index in enumerate(places):
        if own in found.failures:
            continue
        problem, estimates[index], errors[index] = in_chain(
            chains[index], scaled.shock(own), estimates[index], errors[index]
        )
        if problem:
            notes.setdefault(warning_of(problem), []).append(index)
        for note in (*shocks[index].profile.notes, *unusual_warnings(shocks[index], chains[index])):
            notes.setdefault(note, []).append(index)
    forces = contact_forces(shocks, chains)
    warnings = [f"{_numbered(indices)}: {note}" for note, indices in notes.items()]
    return Accuracy(estimates * forces[:, None], None, errors, (*found.warnings, *warnings))


def contact_forces(shocks: Sequence[Shock], chains: Sequence[Chain]) -> FloatArray:
    """Peak forces of shocks at single contacts, of which there are several in packings [N]."""
    forces = [shock.peak_force * chain.contact_share for shock, chain in zip(shocks, chains, strict=True)]
    return np.array(forces, dtype=float)


def _numbered(indices: Sequence[int]) -> str:
    """Shocks by their indices, such as ``Shocks 0, 4 and 5``; of many, the first ones and the number of others."""
    shown = [str(index) for index in indices[:_MOST_NUMBERED]]
    if len(indices) > len(shown):
        shown.append(f"{len(indices) - len(shown)} more")
    return f"Shock{'s' * (len(shown) > 1)} {listed(shown, 'and')}"
