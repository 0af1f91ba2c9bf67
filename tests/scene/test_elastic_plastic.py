"""The elastic-plastic contact law: closed forms, published finite elements, and what thermodynamics demands."""

from __future__ import annotations

import numpy as np
import pytest

from shockwave.scene.elastic_plastic import Loading

#: Ratios of strength and modulus within the range of the law, and an elastic contact.
STRENGTHS = np.array([1e-3, 3e-3, 0.01, 0.03, 0.1, np.inf])


def loading(strengths: np.ndarray = STRENGTHS, modulus: float = 1e11, radius: float = 2e-3) -> Loading:
    radii = np.full(len(strengths), radius)
    return Loading(4 / 3 * modulus * np.sqrt(radii), radii, strengths)


@pytest.mark.parametrize(
    ("strength", "forces"),
    [(600e6, (188.4, 599.2, 1366.1)), (1000e6, (227.0, 763.0, 1826.2)), (2000e6, (270.6, 968.0, 2493.6))],
    ids=["600-MPa", "1000-MPa", "2000-MPa"],
)
def test_loading_is_that_of_finite_elements(strength: float, forces: tuple[float, ...]) -> None:
    # two spheres of 3.175 mm radius, E 100 GPa, nu 0.3, pressed together by 20, 50 and 100 um
    modulus = 100e9 / (1 - 0.09) / 2
    law = loading(np.array([strength / modulus]), modulus, 3.175e-3 / 2)
    values = law.force(np.array([[20e-6], [50e-6], [100e-6]]))[:, 0]
    ratios = values / forces
    assert ((ratios > 0.955) & (ratios < 1.095)).all()


def test_an_overlap_under_a_force_inverts_loading() -> None:
    law = loading()
    overlaps = law.radii * np.geomspace(1e-8, 0.3, 200)[:, None]
    inverse = np.array([law.overlap(each) for each in law.force(overlaps)])
    np.testing.assert_allclose(inverse, overlaps, rtol=1e-12)


def test_loading_is_hertz_up_to_the_cap_and_never_more() -> None:
    law = loading()
    d = law.radii * np.geomspace(1e-8, 1.0, 2000)[:, None]
    ratios = law.force(d) / (law.stiffnesses * d**1.5)
    np.testing.assert_allclose(np.where(d < law.cap_overlaps, ratios, 1.0), 1.0, rtol=1e-14)
    # F/d^(3/2) never increases, so that every unloading dissipates
    assert (np.diff(ratios, axis=0) < 1e-13).all()
    assert (law.cap_overlaps[:5] > 1.5 * law.first_overlaps[:5]).all()


def test_unloading_begins_at_first_yield_and_becomes_stiffer() -> None:
    law = loading()
    yields = law.first_forces[:5]
    at = np.append(yields, 1.0)
    np.testing.assert_allclose(law.unloading_stiffness(at * (1 + 1e-9)), law.stiffnesses, rtol=1e-8)
    d = law.overlap(np.append(20 * yields, 1.0))
    forces = law.force(d)
    stiffer, residual = law.unloading_stiffness(forces), law.residual(d, forces)
    assert (stiffer[:5] > law.stiffnesses[:5]).all()
    assert stiffer[5] == law.stiffnesses[5]
    assert (residual[:5] > 0).all()
    assert residual[5] == 0
    np.testing.assert_allclose(stiffer * (d - residual) ** 1.5, forces, rtol=1e-12)


def test_what_unloading_releases_is_less_than_the_work_of_loading() -> None:
    law = loading()
    d = law.radii * np.geomspace(1e-6, 0.3, 4000)[:, None]
    forces = law.force(d)
    work = np.add.accumulate(0.5 * (forces[1:] + forces[:-1]) * np.diff(d, axis=0)) + 0.4 * forces[0] * d[0]
    stiffnesses = np.array([law.unloading_stiffness(each) for each in forces[1:]])
    released = 0.4 * stiffnesses * (forces[1:] / stiffnesses) ** (5 / 3)
    assert (released <= work * (1 + 1e-5)).all()
    np.testing.assert_allclose(released[:, 5], work[:, 5], rtol=1e-5)


def test_the_law_scales_with_the_radius() -> None:
    small, large = loading(radius=1e-3), loading(radius=2e-3)
    d = np.geomspace(1e-7, 1e-4, 50)[:, None]
    np.testing.assert_allclose(large.force(2 * d), 4 * small.force(d), rtol=1e-12)
