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
    places, given, failures = _scaled(shocks, chains, quadrature, momentum_parameter)
    model = load("models", name)
    with blame("models", model):
        found = model.many(given, settings) if isinstance(model, Model) else _one_by_one(model, given, settings, name)
    failures |= {int(places[index]): reason for index, reason in found.failures.items()}
    amplification = np.full(len(shocks), np.nan)
    error = np.tile([-np.inf, np.inf], (len(shocks), 1))
    method = np.full(len(shocks), "", dtype="U16")
    amplification[places] = found.amplification
    method[places] = found.method
    error[places] = np.stack([found.low, found.high], axis=-1)
    of_chains: Counter[str] = Counter()
    for index, each in enumerate(chains):
        warnings = chain_warnings(each, isinstance(model, Model))
        of_chains.update(warnings)
        if warnings:
            error[index] = -np.inf, np.inf
    counted = [f"{warning}: {count} of {len(chains)}" for warning, count in of_chains.items()]
    notes = dict.fromkeys(note for profile in given.profiles for note in profile.notes)
    return Predictions(
        model=name,
        peak_force=amplification * np.array([shock.peak_force for shock in shocks], dtype=float),
        amplification=amplification,
        expected_error=error,
        method=method,
        failures=tuple(sorted(failures.items())),
        warnings=(*found.warnings, *counted, *notes),
    )


def _listed(name: str, rule: str, values: Any) -> list[Any]:
    try:
        return list(values)
    except TypeError:
        raise InvalidValueError.of(name, f"must be {rule} in a list (got {text_of(values)})") from None


def _scaled(
    shocks: Sequence[Shock], chains: Sequence[Chain], quadrature: str | None, momentum_parameter: float
) -> tuple[Indices, Shocks, dict[int, str]]:
    """The shocks that have a rise time and areas, their indices, and why others have none."""
    profiles: list[ShockProfile] = []
    areas: list[Areas] = []
    shape_of: dict[object, int] = {}  # a profile, or the identity of one that is no value -> index of its shape
    scales_of: dict[tuple[int, float], Scales] = {}
    keys: dict[int, object] = {}
    places, shapes, ratios = [], [], []
    failures = {}
    for index, (shock, chain) in enumerate(zip(shocks, chains, strict=True)):
        if not (isinstance(shock, Shock) and isinstance(chain, Chain)):
            got = f"got {text_of(shock)} and {text_of(chain)}"
            raise InvalidValueError.of(f"shocks[{index}]", f"must be a Shock, and the chain a Chain ({got})")
        profile = shock.profile
        if id(profile) not in keys:
            keys[id(profile)] = profile if is_value(profile) else id(profile)
        shape, units = keys[id(profile)], (id(chain), shock.peak_force)
        try:
            if units not in scales_of:
                scales_of[units] = Scales.of(chain, shock.peak_force)
            ratio = scales_of[units].rise_time(shock.rise_time)
            if shape not in shape_of:
                areas.append(profile.areas(quadrature))
                profiles.append(profile)
                shape_of[shape] = len(profiles) - 1
        except ShockwaveError as error:
            failures[index] = str(error)
            continue
        places.append(index)
        shapes.append(shape_of[shape])
        ratios.append(ratio)
    given = Shocks(
        tuple(profiles),
        tuple(areas),
        np.array(shapes, dtype=np.intp),
        np.array(ratios, dtype=float),
        momentum_parameter,
    )
    return np.array(places, dtype=np.intp), given, failures


def _one_by_one(model: Any, shocks: Shocks, settings: Settings, name: str) -> Peaks:
    """The answers of a model for one shock at a time."""
    peaks = Peaks.of(len(shocks))
    for index in range(len(shocks)):
        shock = shocks.shock(index)
        try:
            answer = model(shock, settings)
            error, _ = expected_error(answer, shock, conditions(shock.areas, shock.profile.duration_ratio))
        except PluginError:
            raise
        except ShockwaveError as failure:
            peaks.failures[index] = str(failure)
            continue
        peaks.amplification[index] = answer.amplitudes[0]
        peaks.method[index] = answer.method or name
        if error is not None:
            peaks.low[index], peaks.high[index] = error
    return peaks
