"""Design: values of parameters of a scene with which forces in the chain, or the leading wave, meet requirements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from shockwave.base.errors import InvalidValueError
from shockwave.base.progress import logger
from shockwave.base.quantities import Quantity
from shockwave.base.quantity_fields import Declaration, text_of
from shockwave.scenario.block_keys import MATERIALS
from shockwave.scenario.scenario import Scenario, SceneArgument
from shockwave.scenario.variations import Family
from shockwave.scene.chain import Chain
from shockwave.studies import varied_scenes
from shockwave.studies.design_one_parameter import compare_values, search_interval
from shockwave.studies.design_options import DesignScenes
from shockwave.studies.design_result import Design, VariedParameter
from shockwave.studies.quantities import Requirement, find_target, list_reported, split_requirement

_POINTS = Declaration("", "number of rows", at_least=2, at_most=1000, whole=True)


def design(
    scene: SceneArgument,
    chain: Chain | None = None,
    *,
    vary: str | Mapping[str, Sequence[Any] | str | None],
    between: Sequence[Any] | None = None,
    among: str | Iterable[str] | None = None,
    target: str | Mapping[str, Any] | Sequence[str],
    budget: str | Sequence[str] = (),
    least: str | None = None,
    points: int = 9,
    rtol: float = 1e-4,
    seed: int = 0,
) -> Design:
    """Values of parameters with which a scene meets requirements, by simulations.

    With one parameter and one requirement the result has all values that meet it. With several of either, or with
    ``least``, it is the option that meets all requirements with the least of a quantity.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    vary : str or mapping
        Dotted name of the parameter: a number or a material of the chain, the shock or the impact, such as
        ``chain.radius`` or ``chain.material``. For several parameters, their names with the ends of the interval of a
        number, or the names of materials, or None for the whole library.
    between : pair, optional
        Ends of the interval of a number, in SI units or as text.
    among : str or iterable of str, optional
        Materials to compare; by default, all materials of the library.
    target, budget : str or sequence of str
        Requirements such as ``"transmitted.peak_force <= 60 N"``: a quantity, ``=``, ``<=`` or ``>=``, and a value. A
        mapping of one quantity to a number in SI units or text is an equality. Quantities have the names of the JSON
        of a simulation: peak_force, amplification, momentum, energy, speed, width, granule_velocity (leading wave),
        greatest_force.peak_force, transmitted.peak_force, transmitted.impulse, dissipated.energy, restitution,
        yield.peak_ratio, contacts[0].peak_force for the first of the reported contacts; and chain.mass, chain.length.
    least : str, optional
        Quantity to minimise; by default chain.mass where the best option is searched.
    points : int
        Number of rows of the table along an interval, 2 to 1000.
    rtol : float
        Largest relative deviation of a solution from the target, 1e-7 to 1e-2. An equality of several parameters
        holds within a thousandth.
    seed : int
        Seed of the search for the best option; the same seed gives the same answer.

    Returns
    -------
    Design
        The solutions, each simulated to 1e-8, or the nearest option.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a name is unknown or a value is out of range.
    NumericalError
        If a simulation fails, or all of those of a search for the best option.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> result = sw.design(
    ...     shock,
    ...     chain,
    ...     vary="chain.diameter",
    ...     target="peak_force = 20 N",
    ...     between=("10 mm", "40 mm"),
    ... )
    >>> (diameter,) = result.solutions[0].values
    >>> f"{1e3 * diameter:.3f} mm"
    '20.250 mm'
    """
    points, rtol = _POINTS.check("points", points), varied_scenes.RTOL.check("rtol", rtol)
    seed = varied_scenes.SEED.check("seed", seed)
    scenario = varied_scenes.scenario_of(scene, chain)
    reported = list_reported(scenario)
    requirements = (*_requirements(target, "target", reported), *_requirements(budget, "budget", reported))
    if not requirements:
        raise InvalidValueError.of("target", "must be given, such as 'transmitted.peak_force <= 60 N' (got nothing)")
    parameters = tuple(_parameters(scenario, vary, between, among))
    single = len(parameters) == len(requirements) == 1 and least is None
    mass = find_target("chain.mass" if least is None else least, reported, "least")
    # along one parameter, the mass of a finite chain is shown beside the quantity
    quantities = [each.quantity for each in requirements] + [mass] * (not single or scenario.chain.count is not None)
    scenes = DesignScenes(
        family=Family(scenario),
        parameters=parameters,
        requirements=requirements,
        quantities=tuple(dict.fromkeys(quantities)),
        least=None if single else mass.name,
    )
    result = scenes.design(_search(scenes, points, rtol, seed))
    logger.info("design of %s: %d scenes simulated", scenario.name or "the scene", len(scenes.tried))
    return result


def _search(scenes: DesignScenes, points: int, rtol: float, seed: int) -> dict[str, Any]:
    """Search for all solutions of one parameter, or the best option."""
    if scenes.least is not None:
        # imports scipy.stats, which one parameter does not need
        from shockwave.studies.design_several_parameters import search_best

        return search_best(scenes, seed)
    if scenes.parameters[0].among or scenes.parameters[0].whole:
        return compare_values(scenes, rtol)
    return search_interval(scenes, points, rtol)


def _requirements(argument: Any, kind: str, reported: Sequence[Quantity]) -> list[Requirement]:
    """Requirements of an argument; ``kind`` is its name."""
    if isinstance(argument, Mapping):
        if len(argument) != 1:
            rule = 'must be one property and its value, such as {"peak_force": "60 N"}'
            raise InvalidValueError.of(kind, f"{rule} (got {text_of(argument)})")
        ((name, value),) = argument.items()
        return [Requirement.of(name, "=", value, reported, kind)]
    if argument is None:
        return []
    texts = [argument] if isinstance(argument, str) or not isinstance(argument, Iterable) else argument
    parts = [split_requirement(text, kind) for text in texts]
    return [Requirement.of(name, sign, value, reported, kind) for name, sign, value in parts]


def _parameters(scenario: Scenario, vary: Any, between: Any, among: Any) -> list[VariedParameter]:
    """The varied parameters, with their intervals or materials."""
    if not vary or not isinstance(vary, str | Mapping):
        rule = 'must be a name, or a mapping of names such as {"chain.radius": ("2 mm", "8 mm")}'
        raise InvalidValueError.of("vary", f"{rule} (got {text_of(vary)})")
    if isinstance(vary, Mapping):
        unused, ranges = {"between": between, "among": among}, vary
    else:
        of_material = vary.endswith(MATERIALS)
        unused = {"between": between} if of_material else {"among": among}
        ranges = {vary: among if of_material else between}
    for argument, value in unused.items():
        if value is not None:
            names = ", ".join(map(str, ranges))
            raise InvalidValueError.of(argument, f"must be omitted for {names} (got {text_of(value)})")
    return [_parameter(scenario, name, values) for name, values in ranges.items()]


def _parameter(scenario: Scenario, name: str, values: Any) -> VariedParameter:
    variable = varied_scenes.find_parameter(name, scenario)
    if name.endswith(MATERIALS):
        return VariedParameter(name=name, among=varied_scenes.materials_of(values))
    if variable.unit is None or not name.startswith(varied_scenes.VARIED):
        raise InvalidValueError.of("vary", f"must be a number or a material of the chain or the shock (got {name})")
    ends = varied_scenes.interval(variable, values)
    return VariedParameter(name=name, unit=variable.unit, whole=variable.whole, between=ends)
