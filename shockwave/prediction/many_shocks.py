"""Predictions of many shocks at once, as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import cmp_using, field, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError, PluginError, ShockwaveError
from shockwave.fields import text_of
from shockwave.prediction.expected_error import chain_warnings, expected_error
from shockwave.prediction.model_interface import Indices, Model, Peaks, Settings, Shocks
from shockwave.profiles.base import Areas, ShockProfile
from shockwave.profiles.conditions import conditions
from shockwave.profiles.guard import is_value
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.registry import blame, load
from shockwave.text import printed

_SAME = cmp_using(eq=np.array_equal)
_SAME_OR_NAN = cmp_using(eq=partial(np.array_equal, equal_nan=True))


def _read_only(values: Any) -> Any:
    values.setflags(write=False)
    return values


@frozen(kw_only=True)
class Predictions:
    """The primaries of many shocks, in their order.

    Attributes
    ----------
    model : str
        Name of the model.
    peak_force, amplification : numpy.ndarray, shape (shocks,)
        Of the primary [N]; over the peak force of the shock. NaN for a shock among ``failures``.
    expected_error : numpy.ndarray, shape (shocks, 2)
        Lowest and highest relative error of ``peak_force`` to be expected; infinite where it is not known.
    method : numpy.ndarray of str, shape (shocks,)
        The method by which each was found; empty for a shock among ``failures``.
    failures : tuple of (int, str)
        Indices of shocks that have no answer, ascending, each with the reason.
    warnings : tuple of str
        What a reader must know before using the figures.
    """

    model: str
    peak_force: FloatArray = field(eq=_SAME_OR_NAN, hash=False, converter=_read_only)
    amplification: FloatArray = field(eq=_SAME_OR_NAN, hash=False, converter=_read_only)
    expected_error: FloatArray = field(eq=_SAME, hash=False, converter=_read_only)
    method: npt.NDArray[np.str_] = field(eq=_SAME, hash=False, converter=_read_only)
    failures: tuple[tuple[int, str], ...]
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.peak_force)

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats, None where there is no number."""
        return {
            "model": self.model,
            "peak_force": _plain(self.peak_force),
            "amplification": _plain(self.amplification),
            "expected_error": [pair if None not in pair else None for pair in map(_plain, self.expected_error)],
            "method": self.method.tolist(),
            "failures": [{"index": index, "reason": reason} for index, reason in self.failures],
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        return printed(self, "shockwave.prediction.outcome_text:predictions_text")


def _plain(values: FloatArray) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]


def predicted(
    name: str,
    settings: Settings,
    quadrature: str | None,
    momentum_parameter: float,
    shocks: Iterable[Shock],
    chain: Chain | Sequence[Chain],
) -> Predictions:
    """The result of `Predictor.predict_many`."""
    shocks = _listed("shocks", "shocks", shocks)
    chains = [chain] * len(shocks) if isinstance(chain, Chain) else _listed("chain", "a Chain, or chains", chain)
    if len(chains) != len(shocks):
        raise InvalidValueError.of("chain", f"must be one, or one for each shock (got {len(chains)})")
    failures: dict[int, str] = {}
    ratios = _rise_times(shocks, chains, failures)
    places, given = _by_shape(shocks, ratios, quadrature, momentum_parameter, failures)
    model = load("models", name)
    with blame("models", model):
        found = model.many(given, settings) if isinstance(model, Model) else _one_by_one(model, given, settings, name)
    amplification = np.full(len(shocks), np.nan)
    error = np.tile([-np.inf, np.inf], (len(shocks), 1))
    method = np.full(len(shocks), "", dtype="U16")
    amplification[places], method[places] = found.amplification, found.method
    error[places, 0], error[places, 1] = found.low, found.high
    warnings = [*found.warnings, *_of_chains(chains, error, isinstance(model, Model))]
    warnings += dict.fromkeys(note for profile in given.profiles for note in profile.notes)
    failures |= {int(places[index]): reason for index, reason in found.failures.items()}
    return Predictions(
        model=name,
        peak_force=amplification * np.array([shock.peak_force for shock in shocks], dtype=float),
        amplification=amplification,
        expected_error=error,
        method=method,
        failures=tuple(sorted(failures.items())),
        warnings=tuple(warnings),
    )


def _listed(name: str, rule: str, values: Any) -> list[Any]:
    try:
        return list(values)
    except TypeError:
        raise InvalidValueError.of(name, f"must be {rule} in a list (got {text_of(values)})") from None


def _of_chains(chains: Sequence[Chain], error: FloatArray, tells_error: bool) -> list[str]:
    """Delete errors that do not hold for a chain; warnings, each with the number of its chains."""
    counts: Counter[str] = Counter()
    for index, chain in enumerate(chains):
        warnings = chain_warnings(chain, tells_error)
        counts.update(warnings)
        if warnings:
            error[index] = -np.inf, np.inf
    return [f"{warning}: {count} of {len(chains)}" for warning, count in counts.items()]


def _rise_times(shocks: Sequence[Shock], chains: Sequence[Chain], failures: dict[int, str]) -> FloatArray:
    """t0/T0 of each, zero for one that has none."""
    known: dict[tuple[int, float], Scales] = {}
    ratios = np.zeros(len(shocks))
    for index, (shock, chain) in enumerate(zip(shocks, chains, strict=True)):
        if not (isinstance(shock, Shock) and isinstance(chain, Chain)):
            got = f"got {text_of(shock)} and {text_of(chain)}"
            raise InvalidValueError.of(f"shocks[{index}]", f"must be a Shock, and the chain a Chain ({got})")
        key = id(chain), shock.peak_force
        try:
            if key not in known:
                known[key] = Scales.of(chain, shock.peak_force)
            ratios[index] = known[key].rise_time(shock.rise_time)
        except ShockwaveError as error:
            failures[index] = str(error)
    return ratios


def _by_shape(
    shocks: Sequence[Shock],
    ratios: FloatArray,
    quadrature: str | None,
    momentum_parameter: float,
    failures: dict[int, str],
) -> tuple[Indices, Shocks]:
    """Those that have a rise time and whose shape has areas, and their indices."""
    profiles: list[ShockProfile] = []
    areas: list[Areas] = []
    shape_of: dict[int, int | str] = {}  # identity of a profile -> index of its shape, or why it has no areas
    by_value: dict[ShockProfile, int | str] = {}
    for profile in {id(shock.profile): shock.profile for shock in shocks}.values():
        shape = by_value.get(profile) if is_value(profile) else None
        if shape is None:
            try:
                areas.append(profile.areas(quadrature))
                profiles.append(profile)
                shape = len(profiles) - 1
            except ShockwaveError as error:
                shape = str(error)
            if is_value(profile):
                by_value[profile] = shape
        shape_of[id(profile)] = shape
    places, shapes = [], []
    for index in np.flatnonzero(ratios).tolist():
        shape = shape_of[id(shocks[index].profile)]
        if isinstance(shape, str):
            failures[index] = shape
        else:
            places.append(index)
            shapes.append(shape)
    where, which = np.array(places, dtype=np.intp), np.array(shapes, dtype=np.intp)
    return where, Shocks(tuple(profiles), tuple(areas), which, ratios[where], momentum_parameter)


def _one_by_one(model: Any, shocks: Shocks, settings: Settings, name: str) -> Peaks:
    """The answers of a model for one shock at a time."""
    peaks = Peaks.of(len(shocks))
    pairs = zip(shocks.areas, shocks.profiles, strict=True)
    checked = [conditions(areas, profile.duration_ratio) for areas, profile in pairs]
    for index in range(len(shocks)):
        shock = shocks.shock(index)
        try:
            answer = model(shock, settings)
            error, _ = expected_error(answer, shock, checked[shocks.shapes[index]])
        except PluginError:
            raise
        except ShockwaveError as failure:
            peaks.failures[index] = str(failure)
            continue
        peaks.amplification[index], peaks.method[index] = answer.amplitudes[0], answer.method or name
        if error is not None:
            peaks.low[index], peaks.high[index] = error
    return peaks
