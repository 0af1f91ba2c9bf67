"""Prediction, simulation and comparison of a scenario, or of a shock or an impact on a chain."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, cast

import attrs
from attrs import evolve

from shockwave.base.arguments import unknown_arguments
from shockwave.base.errors import InvalidValueError, refuse
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions, options_of

if TYPE_CHECKING:
    from typing import Unpack

    from shockwave.arguments import PredictArguments, SimulateArguments
    from shockwave.base.quantity_fields import Number
    from shockwave.prediction.outcome import Outcome
    from shockwave.prediction.predictor import Predictor
    from shockwave.scenario.scenario import Scenario, SceneArgument
    from shockwave.scene.chain import Chain
    from shockwave.scene.force_limit import Limit
    from shockwave.scene.shock import Shock
    from shockwave.simulation.simulation_result import Simulation
    from shockwave.studies.comparison import Comparison


def predict(
    scene: SceneArgument,
    chain: Chain | None = None,
    *,
    limit: Limit | Number | None = None,
    **settings: Unpack[PredictArguments],
) -> Outcome:
    """Predict the waves that a shock or a striker generates: simulated values, with those of section 4.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    limit : Limit, float or str, optional
        Limit on the transmitted force, or this force [N]; by default that of the scenario.
    **settings
        Options of `simulate`, and settings of `Predictor`: ``model``, "best" (default) or "section-4";
        ``momentum_coefficient``, "exact" (default), "paper" or a number; ``alpha``, "constant" (default) or "literal";
        ``equal_tolerance``, 0 to below 1, default 0.05; ``quadrature``, the name of a registered one. They replace
        those of the scenario. A ``wave_threshold``, default 0.005, is that of the waves in both.

    Raises
    ------
    InvalidValueError
        If the scene, a setting or an option is not valid; for a scenario, located in its file.
    NotCoveredError
        If the model is ``section-4``, and it does not cover the scene.
    ShockwaveError
        As `Predictor.predict` and `load_scenario`.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> outcome = sw.predict(shock, chain)
    >>> f"{outcome.peak_force:.4f} N, {outcome.regime}, {outcome.section4.error:+.1%}"
    '53.6106 N, train, +5.2%'
    """
    case, scenario = _case(scene, chain, limit)
    predictor, options = settings_of(scenario, {**settings})
    with case.locate_errors():
        return predictor.predict_scene(case, options)


def simulate(
    scene: SceneArgument,
    chain: Chain | None = None,
    rtol: Number | None = None,
    *,
    limit: Limit | Number | None = None,
    **options: Unpack[SimulateArguments],
) -> Simulation:
    """Integrate eq. (1) and measure the waves that form, or in other chains the greatest forces at the contacts.

    The leading wave is followed until its peak force has reached its limit along the chain. The other waves and the
    rebounding granules are integrated when they are first accessed. Quantities are numbers in SI units, text with a
    unit or quantities of pint; options replace those of the scenario.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    rtol : float, optional
        Relative error of the peak force, 1e-13 to 1e-2. Default: 1e-6.
    limit : Limit, float or str, optional
        Limit on the transmitted force, or this force [N]; by default that of the scenario.
    integrator : str, optional
        Name of a registered integrator. Default: rkn86, or rkn1210 for a tolerance below 1e-7.
    step : float, optional
        Step size of a fixed-step method in characteristic times of the wave, above 0 and at most 1. Default: 0.02.
    wave_threshold : float, optional
        Weakest wave that counts, relative to the leading wave, 1e-3 to below 1. Default: 0.005.
    waves : "train" or "primary", optional
        All waves and the rebounding granules (default), or the leading wave alone.
    backend : "auto", "compiled" or "numpy", optional
        Code that integrates the chain. ``auto`` (default) is the compiled code if it was built.
    contacts : sequence of int, optional
        Contacts, from 0 to 1e12, at which the passage of the leading wave or, in a finite chain, the greatest force is
        reported. Default: none in an endless chain, all in a finite one, evenly spaced beyond 1000.
    record : sequence of "forces", "field", "energies", optional
        Histories to record: forces at ``contacts``, positions and velocities of all granules, energies. Default: none.
    sensors : sequence of str or mapping, optional
        Sensors whose histories and first pulses are computed: ``"wall"``, ``"structure"``, ``{"contact": 5}``,
        ``{"granule": 10}`` (the mean of its two contact forces), also with ``"quantity"``: ``"velocity"`` or
        ``"displacement"``. Default: none.
    interval, until : float, optional
        Sampling interval of the histories and their end [s], 1e-30 to 1e30. Default: a tenth of the characteristic time
        of the wave, and shortly after the leading wave has passed the last of ``contacts`` or was measured. ``until``
        also ends the simulated time of a finite chain.
    timeout : float, optional
        Maximum computing time [s], above 0. Default: no limit.

    Returns
    -------
    Simulation
        Result in SI units; parts that the scene does not have are None or empty.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or not used by the method, or a name is unknown; faults of a scenario are located
        in its file.
    NumericalError
        If the integrator fails, no wave forms, the shock is too long, or the time limit is reached.
    ShockwaveError
        As `load_scenario`.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> result = sw.simulate(shock, chain, rtol=1e-8)
    >>> f"{result.peak_force:.5f} N within {result.error_estimate:.0e}"
    '53.61058 N within 9e-10'
    """
    from shockwave.simulation.simulate import simulate_scene

    settings = {**options} if rtol is None else {**options, "rtol": rtol}
    case, scenario = _case(scene, chain, limit)
    with case.locate_errors():
        return simulate_scene(case, options_of(settings) if scenario is None else _options(scenario, settings))


def compare(
    scene: SceneArgument,
    chain: Chain | None = None,
    *,
    limit: Limit | Number | None = None,
    **settings: Unpack[PredictArguments],
) -> Comparison:
    """Simulate a shock on a chain, and compare section 4 of the paper with the result.

    Parameters
    ----------
    scene, chain, limit, **settings
        As in `predict`; a ``model`` may only be ``section-4``.

    Raises
    ------
    ShockwaveError
        As `predict` and `simulate`.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> comparison = sw.compare(shock, chain)
    >>> comparison.agrees, f"{comparison.errors.peak_force:+.1%}"
    ({'relation': True, 'regime': True, 'count': True}, '+5.2%')
    """
    from shockwave.studies import comparison

    if settings.get("model", "section-4") != "section-4":
        rule = "must be left out or section-4, the model that is compared with the simulation"
        raise InvalidValueError.of("model", f"{rule} (got {settings['model']!r})")
    case, scenario = _case(scene, chain, limit)
    predictor, options = settings_of(scenario, {**settings, "model": "section-4"})
    with case.locate_errors():
        return comparison.compare(case, predictor, options, None if scenario is None else scenario.published)


def _case(scene: object, chain: object, limit: Limit | Number | None) -> tuple[Scene, Scenario | None]:
    """The scene with this limit, if one is given; and its scenario, loaded if ``scene`` is a path."""
    if chain is not None and not isinstance(scene, str | os.PathLike):
        return Scene(excitation=cast("Shock", scene), chain=cast("Chain", chain), limit=limit), None
    from shockwave.scenario.scenario import scenario_alone  # an excitation on a chain does not need it

    scenario = scenario_alone(scene, chain)
    return (scenario.scene if limit is None else evolve(scenario.scene, limit=limit)), scenario


def settings_of(scenario: Scenario | None, arguments: dict[str, Any]) -> tuple[Predictor, SimulateOptions]:
    """Predictor and options with the ``arguments`` in the place of those of the scenario."""
    from shockwave.prediction.predictor import Predictor

    of_predictor, of_options = (set(attrs.fields_dict(cls)) for cls in (Predictor, SimulateOptions))
    refuse(unknown_arguments(arguments, sorted({"limit"} | of_predictor | of_options)))
    settings = {name: value for name, value in arguments.items() if name in of_predictor}
    options = {name: value for name, value in arguments.items() if name in of_options}
    if scenario is None:
        return Predictor(**settings), options_of(options)
    return evolve(scenario.predictor, **settings), _options(scenario, options)


def _options(scenario: Scenario, changes: dict[str, Any]) -> SimulateOptions:
    """The scenario's options with these ``changes``."""
    refuse(unknown_arguments(changes, ["limit", *attrs.fields_dict(SimulateOptions)]))
    # a method named here has a use for its own settings, not for those of the one that it replaces
    if "integrator" in changes:
        changes = {"rtol": None, "step": None} | changes
    return evolve(scenario.simulate, **changes)
