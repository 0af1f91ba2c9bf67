"""The chain: its contact law and A of eq. (4c), the checks on a material, and the scales of eq. (1)."""

from __future__ import annotations

import math
from typing import Any

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shockwave.chain import Chain, Material, Scales
from shockwave.errors import InvalidValueError

STEEL = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
PTFE = Material(youngs_modulus=1.46e9, poisson_ratio=0.46, density=2178.0)
AUXETIC = Material(youngs_modulus=5e7, poisson_ratio=-0.7, density=120.0)
#: The beads of the paper's tables: 9.5 mm across.
BEADS = Chain(material=STEEL, radius=4.75e-3)

CHAINS = [
    pytest.param(BEADS, id="paper"),
    pytest.param(Chain(material=PTFE, radius=2.38e-3), id="ptfe"),
    pytest.param(Chain(material=AUXETIC, radius=0.3), id="auxetic"),
]
SIZES = (1e-9, 1e-6, 1.0, 1e3)
EXTREMES = [
    pytest.param(Material(youngs_modulus=e, poisson_ratio=nu, density=rho), id=name)
    for name, e, nu, rho in [
        ("aerogel", 1e3, 0.0, 1.0),
        ("diamond", 1.2e12, 0.07, 3500.0),
        ("neutron-star-crust", 1e30, 0.49999, 1e17),
        ("nearly-nothing", 1e-6, -0.9999999, 1e-6),
    ]
]


# ---------------------------------------------------------------- formulae


@pytest.mark.parametrize("chain", CHAINS)
class TestFormulae:
    # Products of a handful of numbers and one root: a few roundings each.
    def test_mass(self, chain: Chain) -> None:
        volume = math.pi * (2 * chain.radius) ** 3 / 6
        assert chain.granule_mass == pytest.approx(volume * chain.material.density, rel=1e-15)

    def test_contact_stiffness(self, chain: Chain) -> None:
        # Hertz for any two spheres: 4/3 E* sqrt(R*), with 1/E* and 1/R* sums over both.
        joint_modulus = chain.material.youngs_modulus / (2 * (1 - chain.material.poisson_ratio**2))
        hertz = 4 / 3 * joint_modulus * math.sqrt(chain.radius / 2)
        assert chain.contact_stiffness == pytest.approx(hertz, rel=1e-15)

    def test_momentum_parameter(self, chain: Chain) -> None:
        material = chain.material
        group = (1 - material.poisson_ratio**2) * material.density**1.5 * chain.radius**4
        assert chain.momentum_parameter(13 / 3) == pytest.approx(
            13 / 3 * (group / material.youngs_modulus) ** (1 / 3), rel=1e-15
        )

    def test_time_unit(self, chain: Chain) -> None:
        expected = chain.granule_mass**0.5 * chain.contact_stiffness ** (-1 / 3) * 70.0 ** (-1 / 6)
        assert Scales.of(chain, 70.0).time == pytest.approx(expected, rel=1e-15)

    def test_scaled_equation_of_motion_has_unit_coefficients(self, chain: Chain) -> None:
        # m x'' = k d^(3/2): a granule under the unit force moves the unit overlap in the unit time.
        scales = Scales.of(chain, 70.0)
        overlap = (scales.force / chain.contact_stiffness) ** (2 / 3)
        assert scales.mass * overlap / scales.time**2 == pytest.approx(scales.force, rel=3e-15)

    def test_derived_units(self, chain: Chain) -> None:
        scales = Scales.of(chain, 70.0)
        assert scales.momentum == pytest.approx(scales.mass * scales.velocity, rel=1e-15)
        assert scales.energy == pytest.approx(scales.mass * scales.velocity**2, rel=1e-15)
        assert scales.wave_speed == pytest.approx(2 * chain.radius / scales.time, rel=1e-15)


def test_beads_of_the_paper_have_its_time() -> None:
    # A F0^(-1/6) = 24.024 us at 100 N with the paper's 13/3, to the digits given.
    assert BEADS.momentum_parameter(13 / 3) * 100 ** (-1 / 6) == pytest.approx(24.024e-6, abs=0.5e-9)


def test_beads_of_the_paper_have_its_time_unit() -> None:
    assert Scales.of(BEADS, 100.0).time == pytest.approx(14.58e-6, abs=0.5e-8)


def test_the_momentum_parameter_is_proportional_to_its_coefficient() -> None:
    assert BEADS.momentum_parameter(2.0) == 2 * BEADS.momentum_parameter(1.0)


@pytest.mark.parametrize(
    ("change", "power"),
    [("radius", 4 / 3), ("density", 1 / 2), ("youngs_modulus", -1 / 3)],
    ids=["radius", "density", "stiffness"],
)
def test_the_momentum_parameter_follows_eq_4c(change: str, power: float) -> None:
    twice = (
        attrs.evolve(BEADS, radius=2 * BEADS.radius)
        if change == "radius"
        else attrs.evolve(BEADS, material=attrs.evolve(STEEL, **{change: 2 * getattr(STEEL, change)}))
    )
    assert twice.momentum_parameter(1.0) / BEADS.momentum_parameter(1.0) == pytest.approx(2**power, rel=1e-14)


# ---------------------------------------------------------------- scaling law


@settings(derandomize=True, deadline=None)
@given(
    lam=st.floats(1e-6, 1e6),
    force=st.floats(1e-6, 1e9),
    attribute_and_power=st.sampled_from(
        [("time", -1 / 4), ("velocity", 5 / 4), ("momentum", 5 / 4), ("energy", 5 / 2), ("wave_speed", 1 / 4)]
    ),
)
def test_scales_follow_the_symmetry_of_eq_1(lam: float, force: float, attribute_and_power: tuple[str, float]) -> None:
    # x -> lam x, t -> lam^(-1/4) t, F -> lam^(3/2) F leaves eq. (1) unchanged.
    attribute, power = attribute_and_power
    before, after = Scales.of(BEADS, force), Scales.of(BEADS, lam**1.5 * force)
    # Powers of numbers up to 1e15.
    assert getattr(after, attribute) == pytest.approx(lam**power * getattr(before, attribute), rel=1e-13)


# ---------------------------------------------------------------- extremes


@pytest.mark.parametrize("material", EXTREMES)
@pytest.mark.parametrize("radius", SIZES, ids=str)
class TestExtremeSizes:
    def test_properties_are_finite(self, radius: float, material: Material) -> None:
        chain = Chain(material=material, radius=radius)
        found = [chain.granule_mass, chain.contact_stiffness, chain.momentum_parameter(13 / 3)]
        assert all(math.isfinite(value) and value > 0 for value in found)

    @pytest.mark.parametrize("force", [1e-12, 1e12], ids=str)
    def test_scales_are_finite(self, radius: float, material: Material, force: float) -> None:
        scales = Scales.of(Chain(material=material, radius=radius), force)
        found = [scales.time, scales.velocity, scales.momentum, scales.energy, scales.wave_speed]
        assert all(math.isfinite(value) and value > 0 for value in found)


@pytest.mark.parametrize("radius", [1e-150, 1e103, 1e200, 1e308], ids=str)
def test_a_size_beyond_floating_point_numbers_is_refused(radius: float) -> None:
    with pytest.raises(InvalidValueError, match=r"^radius: must give granules a mass"):
        Chain(material=STEEL, radius=radius)


@pytest.mark.parametrize("radius", [1e-90, 1e100], ids=str)
def test_a_size_within_floating_point_numbers_has_a_momentum_parameter(radius: float) -> None:
    # R^(4/3) is a floating-point number, though R^4 is not.
    expected = BEADS.momentum_parameter(1.0) * (radius / BEADS.radius) ** (4 / 3)
    found = Chain(material=STEEL, radius=radius).momentum_parameter(1.0)
    assert found == pytest.approx(expected, rel=1e-13, abs=0)


# ---------------------------------------------------------------- checks


GOOD = {"youngs_modulus": 193e9, "poisson_ratio": 0.3, "density": 7958.0}
RULES = {
    "youngs_modulus": "must be > 0 Pa",
    "poisson_ratio": "must be > -1 and < 0.5",
    "density": "must be > 0 kg/m**3",
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("youngs_modulus", 0),
        ("youngs_modulus", -193e9),
        ("poisson_ratio", -1),
        ("poisson_ratio", 0.5),
        ("poisson_ratio", 30),
        ("density", 0.0),
        ("density", -1),
        *((name, value) for name in GOOD for value in (math.nan, math.inf, -math.inf, "0.3", True, [0.3])),
    ],
    ids=lambda value: repr(value),
)
def test_a_wrong_figure_of_a_material_is_refused_with_its_rule(name: str, value: object) -> None:
    with pytest.raises(InvalidValueError) as caught:
        Material(**{**GOOD, name: value})
    assert str(caught.value) == f"{name}: {RULES[name]} (got {value!r})"


@pytest.mark.parametrize("name", GOOD)
def test_a_missing_figure_is_refused(name: str) -> None:
    with pytest.raises(InvalidValueError, match=rf"^{name}: must be .*\(got nothing\)$"):
        Material(**{**GOOD, name: None})


@pytest.mark.parametrize("ratio", [-0.999, 0, 0.499], ids=str)
def test_the_whole_range_of_the_poisson_ratio_is_taken(ratio: float) -> None:
    assert Material(**{**GOOD, "poisson_ratio": ratio}).poisson_ratio == ratio


@pytest.mark.parametrize("radius", [0, -1.0, math.nan, math.inf, "4.75 mm", False], ids=repr)
def test_a_wrong_radius_is_refused_with_its_rule(radius: object) -> None:
    with pytest.raises(InvalidValueError) as caught:
        Chain(material=STEEL, radius=radius)
    assert str(caught.value) == f"radius: must be > 0 m (got {radius!r})"


@pytest.mark.parametrize("granules", [1, 0, -3, 2.5, "20", True], ids=repr)
def test_a_wrong_number_of_granules_is_refused(granules: object) -> None:
    with pytest.raises(InvalidValueError, match=r"^granules: must be a whole number >= 2"):
        Chain(material=STEEL, radius=1e-3, granules=granules)


@pytest.mark.parametrize("material", ["steel", None, 193e9], ids=repr)
def test_what_is_no_material_is_refused(material: Any) -> None:
    with pytest.raises(InvalidValueError, match="material"):
        Chain(material=material, radius=1e-3)


@pytest.mark.parametrize(
    ("thing", "name"), [(STEEL, "density"), (BEADS, "radius"), (Scales.of(BEADS, 1.0), "time")], ids=str
)
def test_values_are_frozen(thing: object, name: str) -> None:
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        setattr(thing, name, 1.0)


def test_chains_of_equal_values_are_equal() -> None:
    assert Chain(material=attrs.evolve(STEEL), radius=4.75e-3) == BEADS
