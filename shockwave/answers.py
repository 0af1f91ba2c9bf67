"""Prediction, simulation and comparison of a scenario, or of a shock or an impact on a chain."""

from __future__ import annotations

import functools
import os
from typing import TYPE_CHECKING, Any, cast

from attrs import evolve

from shockwave.errors import NotCoveredError
from shockwave.options import SimulateOptions

if TYPE_CHECKING:
    from shockwave.chain.chain import Chain
    from shockwave.chain.impact import Impact
    from shockwave.limit import Limit
    from shockwave.prediction.outcome import Outcome
    from shockwave.prediction.predictor import Predictor
    from shockwave.profiles.shock import Shock
    from shockwave.scenario.scenario import Scenario
    from shockwave.scenario.scene_argument import Scene
    from shockwave.studies.comparison import Comparison


# Plain options are cached, so that repeated ones are not checked again; typed, because 1 == True.
_kept_options = functools.lru_cache(maxsize=64, typed=True)(SimulateOptions)


def predict(
    scene: Scene, chain: Chain | None = None, *, limit: Limit | float | str | None = None, **settings: Any
) -> Outcome:
    """Predict the waves that a shock or a striker generates, and the force on a wall.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    limit : Limit, float or str, optional
        Limit of the force that leaves the chain, or this force [N]; by default that of the scenario.
    **settings
        Settings of `Predictor`, which replace those of the scenario.

    Raises
    ------
    NotCoveredError
        If the model does not cover the scene; for a scenario, located in its file.
    ShockwaveError
        As `Predictor.predict` and `load_scenario`.
    """
    from shockwave.prediction.predictor import Predictor

    scenario = _scenario(scene, chain)
    if scenario is None:
        outcome = Predictor(**settings).predict(cast("Shock | Impact", scene), cast("Chain", chain))
        return cast("Outcome", _limited(outcome, limit))
    try:
        outcome = _predictor(scenario, settings).predict(scenario.excitation, scenario.chain)
    except NotCoveredError as error:
        raise scenario.located(error) from None
    return cast("Outcome", _limited(evolve(outcome, scenario=scenario.name, limit=scenario.limit), limit))


def simulate(
    scene: Scene,
    chain: Chain | None = None,
    rtol: float | None = None,
    *,
    limit: Limit | float | str | None = None,
    **options: Any,
) -> Any:
    """Integrate eq. (1) and measure the waves that form, or in other chains the greatest forces at the contacts.

    The leading wave is followed until its peak force has reached its limit along the chain. The other waves and the
    rebounding granules are integrated when they are first accessed.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    rtol : float, optional
        Relative error of the peak force, 1e-13 to 1e-2; default 1e-6.
    limit : Limit, float or str, optional
        Limit of the force that leaves the chain, or this force [N]; by default that of the scenario.
    **options
        ``integrator``, ``step``, ``wave_threshold``, ``waves``, ``backend``, ``contacts``, ``record``, ``interval``,
        ``until`` and ``timeout`` of `SimulateOptions`; those given replace those of the scenario.

    Returns
    -------
    SimulationResult or ChainResult
        Result in SI units; a `ChainResult` for a chain with features beyond equal spheres and free ends.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or not used by the method, or a name is unknown.
    NumericalError
        If the integrator fails, no wave forms, the shock is too long, or the time limit is reached.
    ShockwaveError
        As `load_scenario`.
    """
    from shockwave.measurement.simulate import simulate_with

    options |= {} if rtol is None else {"rtol": rtol}
    scenario = _scenario(scene, chain)
    if scenario is None:
        plain = all(value is None or isinstance(value, str | int | float) for value in options.values())
        made = (_kept_options if plain else SimulateOptions)(**options)
        return _limited(simulate_with(made, cast("Shock", scene), cast("Chain", chain)), limit)
    result = simulate_with(_options(scenario, options), scenario.excitation, scenario.chain)
    return _limited(evolve(result, scenario=scenario.name, limit=scenario.limit), limit)


def compare(
    scene: Scene,
    chain: Chain | None = None,
    predictor: Predictor | None = None,
    options: SimulateOptions | None = None,
    *,
    limit: Limit | float | str | None = None,
    **asked: Any,
) -> Comparison:
    """Predict and simulate a scene; simulate alone where the model does not cover it.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    predictor : Predictor, optional
        By default that of the scenario, or one with its defaults.
    options : SimulateOptions, optional
        By default those of the scenario; or else ``asked``.
    limit : Limit, float or str, optional
        Limit of the force that leaves the chain, or this force [N]; by default that of the scenario.
    **asked
        Options of `simulate`.

    Raises
    ------
    ShockwaveError
        As `predict` and `simulate`.
    """
    from shockwave.studies import comparison

    scenario = _scenario(scene, chain)
    if scenario is None:
        found = comparison.compare(cast("Shock", scene), cast("Chain", chain), predictor, options, **asked)
        return _both_limited(found, limit)
    options = _options(scenario, asked) if options is None else options
    found = comparison.compare(scenario.excitation, scenario.chain, predictor or scenario.predictor, options)
    predicted = found.predicted and evolve(found.predicted, scenario=scenario.name, limit=scenario.limit)
    simulated = evolve(found.simulated, scenario=scenario.name, limit=scenario.limit)
    return _both_limited(evolve(found, predicted=predicted, simulated=simulated, published=scenario.published), limit)


def _limited(result: Any, limit: Limit | float | str | None) -> Any:
    """The result with this limit, if one is given."""
    if limit is None:
        return result
    from shockwave.limit import limit_of

    return evolve(result, limit=limit_of(limit))


def _both_limited(found: Comparison, limit: Limit | float | str | None) -> Comparison:
    """The comparison with this limit of both results, if one is given."""
    predicted = found.predicted and _limited(found.predicted, limit)
    return evolve(found, predicted=predicted, simulated=_limited(found.simulated, limit))


def _scenario(scene: object, chain: object) -> Scenario | None:
    """The scenario, loaded if ``scene`` is a path; None for an excitation with a chain."""
    if chain is not None and not isinstance(scene, str | os.PathLike):
        return None
    from shockwave.scenario.scene_argument import scenario_alone  # an excitation on a chain does not need it

    return scenario_alone(scene, chain)


def _predictor(scenario: Scenario, settings: dict[str, Any]) -> Predictor:
    return evolve(scenario.predictor, **settings)


def _options(scenario: Scenario, given: dict[str, Any]) -> SimulateOptions:
    """The scenario's options with those ``given`` in their place."""
    # a method named here has a use for its own settings, not for those of the one that it replaces
    if "integrator" in given:
        given = {"rtol": None, "step": None} | given
    return evolve(scenario.simulate, **given)
