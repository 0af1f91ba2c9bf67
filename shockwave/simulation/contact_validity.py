"""Comparison of contacts with first yield, and with the range of overlaps for which Hertz's law holds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shockwave.base.text import round_digits, si
from shockwave.engine.chain_motion import ChainMotion
from shockwave.scene.yielding import OTHER_LAWS, UNJUDGED, Yielding, first_yield_force
from shockwave.simulation.contact_setup import ChainSetup

# Overlap, over the reduced radius of the contact, beyond which Hertz's law is doubtful.
_LARGE_OVERLAP = 0.1
# Error of the energy that a contact has lost, over rtol and the energy that it received: measured up to 1, and more for
# laws that are far softer than Hertz's, by which this energy is estimated.
_ENERGY_ERROR = 10.0


def warn_unjudged(case: ChainSetup, yielding: Yielding | None) -> Iterator[str]:
    """Warnings of contacts that are not compared with first yield."""
    strengths, hertz = case.layout.strengths, case.layout.hertz_contacts
    unknown = int((np.isnan(strengths) & hertz).sum())
    if yielding is not None and unknown:
        where = "1 contact" if unknown == 1 else f"{unknown} contacts"
        yield f"{UNJUDGED} at {where}, because a yield strength is not known (state yield_strength)."
    if not hertz.all() and np.isfinite(strengths).any():
        yield OTHER_LAWS


def first_yield(case: ChainSetup, motion: ChainMotion) -> Yielding | None:
    """First yield in the weaker material of each contact by Hertz's law, where both yield strengths are known."""
    layout, softer = case.layout, case.layout.strengths
    at = np.flatnonzero(np.isfinite(softer) & layout.hertz_contacts)
    if not at.size or (case.scene.chain.elastic_only and np.isnan(softer[layout.hertz_contacts]).any()):
        return None
    radii, moduli = layout.pairs.radii[at], layout.pairs.moduli[at]
    first = first_yield_force(radii, moduli, softer[at])
    ratios = motion.forces[at] * case.scales.force / first
    plastic = np.zeros(at.shape) if layout.plastic is None else np.isfinite(layout.plastic.strengths[at])
    elastic = np.where(plastic, 0.0, ratios)
    alike = bool((layout.radii == layout.radii[0]).all()) and all(body == layout.materials[0] for body in layout.bodies)
    return Yielding(
        first_yield_force=float(first.min()),
        peak_ratio=float(ratios.max()),
        elastic_ratio=float(elastic.max()),
        place="" if alike or not elastic.any() else layout.describe_contact(int(at[elastic.argmax()])),
        yielded_contacts=None if case.scene.chain.count is None else int((ratios > 1).sum()),
    )


def warn_created_energy(case: ChainSetup, motion: ChainMotion) -> Iterator[str]:
    """Warning of contacts with the law of a plugin that have returned more energy than they received."""
    if case.layout.law is None:
        return
    layout, scales = case.layout, case.scales
    gains = np.where(layout.law_contacts, -motion.losses[: len(motion.forces)], 0.0) * scales.energy
    # a slow shock pushes a contact together and takes the energy back: its net work can be small
    forces = motion.forces * scales.force
    passed = forces * (forces / layout.pairs.stiffnesses) ** (2 / 3)
    passed += (motion.work + motion.initial_energy) * scales.energy
    excess = gains - _ENERGY_ERROR * case.rtol * passed - abs(motion.energy_balance) * scales.energy
    worst = int(np.argmax(excess))
    if excess[worst] > 0:
        law, energy = type(layout.law).__name__, si(gains[worst], "J", 3)
        yield f"The contact law {law} creates energy: contact {worst} has returned {energy} more than it received."


def warn_overlaps(case: ChainSetup, motion: ChainMotion) -> Iterator[str]:
    """Warning of overlaps for which Hertz's law, and that of elastic-plastic contacts, do not hold."""
    pairs = case.layout.pairs
    overlaps = (motion.forces * case.scales.force / pairs.stiffnesses) ** (2 / 3)
    if motion.greatest_overlaps is not None:
        overlaps = np.maximum(overlaps, case.scales.energy / case.scales.force * motion.greatest_overlaps)
    ratios = np.where(case.layout.hertz_contacts, overlaps / pairs.radii, 0.0)
    worst = int(np.argmax(ratios))
    if ratios[worst] > _LARGE_OVERLAP:
        overlap = f"An overlap is about {round_digits(ratios[worst])} times the reduced radius, at contact {worst}"
        yield f"{overlap}: Hertz's law holds for small overlaps only."
