"""Regimes of section 4 over the points of a sweep, as numbers whose sign changes at their borders."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from shockwave.chain.chain import Scales
from shockwave.chain.solitary_wave import EXACT_COEFFICIENT, MOMENTUM
from shockwave.errors import FileAccessError, ShockwaveError
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.predictor import coefficient_of
from shockwave.prediction.section4 import constant_alpha
from shockwave.scenario.loader import load_scenario
from shockwave.scenario.scene_family import Family
from shockwave.sweep.results import SweepResults

# A picture of more points shows no finer border.
_MOST = 20_000
_COLUMNS = ("regime", "predicted_regime")


def regimes(results: SweepResults, indices: npt.NDArray[np.intp]) -> tuple[dict[str, npt.NDArray[np.float64]], str]:
    """Numbers that are below 0 within each regime and above outside, and a sentence on where they come from.

    By (5d) a train has n t0 > alphaF0 A F0^(-1/6), and by (5e) and 4.2.2 an ejection of one wave an impulse over F0
    < A F0^(-1/6): the numbers are logarithms of these ratios, so that borders are known better than to a point. Where
    the sweep's own predictions say otherwise, or there is no scenario to predict from, they jump from point to point.

    Parameters
    ----------
    results : SweepResults
        The sweep; its folder holds the scenario.
    indices : array of int, shape (p,)
        Points.

    Returns
    -------
    dict of str to array, shape (p,)
        Empty where nothing is known.
    """
    name = next((column.name for column in results.columns if column.name in _COLUMNS), None)
    told = results.values(name).ravel()[indices] if name else np.full(len(indices), "")
    known = np.unique(told[told != ""])
    found: dict[str, npt.NDArray[np.float64]] = {}
    lack = f"more than {_MOST} points"
    if len(indices) <= _MOST:
        try:
            found = _by_section_4(results, indices)
        except ShockwaveError as error:
            lack = str(error).partition("\n")[0]
            if isinstance(error, FileAccessError):
                lack += " (a folder of results holds no copies of records: put them beside its scenario.yaml)"
    if found and all(one in found and ((found[one] < 0) == (told == one))[told != ""].all() for one in known):
        return found, "borders of the regimes: (5d) and (5e) of section 4, for each point"
    if name:
        # a point without a prediction is in no regime
        return {one: np.where(told == one, -0.5, 0.5) for one in known.tolist()}, f"borders of the regimes: {name}"
    return {}, f"no borders of regimes: {lack}"


def _by_section_4(results: SweepResults, indices: npt.NDArray[np.intp]) -> dict[str, npt.NDArray[np.float64]]:
    family = Family(load_scenario(results.folder / "scenario.yaml"))
    longer, weaker = np.full(len(indices), np.nan), np.full(len(indices), np.nan)
    for at, index in enumerate(indices):
        try:
            scene = family.scenario(results.point(int(index)))
            shock, coefficient = scene.shock, coefficient_of(scene.predictor.momentum_coefficient)
            parameter = MOMENTUM * coefficient / EXACT_COEFFICIENT
            rise_time = Scales.of(scene.chain, shock.peak_force).rise_time(shock.rise_time)
            scaled = ScaledShock(shock.profile, shock.profile.areas(), rise_time, parameter)
            alpha = constant_alpha(scaled)
        except Exception:  # a point that failed has no regime, whatever its profile has raised
            continue
        longer[at] = math.log(scaled.duration / (alpha * parameter))
        weaker[at] = math.log(scaled.impulse / parameter)
    return {
        "ejection": np.maximum(longer, weaker),
        "single": np.maximum(longer, -weaker),
        "train": -longer,
    }
