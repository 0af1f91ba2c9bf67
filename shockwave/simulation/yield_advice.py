"""Forces with elastic-plastic contacts, as advice on a chain that is elastic beyond first yield."""

from __future__ import annotations

from shockwave.base.errors import ShockwaveError
from shockwave.base.text import si
from shockwave.scene.layout import plastic_chain
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_forces import simulate_chain
from shockwave.simulation.contact_setup import check_setup
from shockwave.simulation.simulation_result import Simulation

# Longest chain that is simulated for a sentence, and the tolerance and digits of its forces.
_MOST = 100
_RTOL = 1e-3
_DIGITS = 3


def value_with_yield(result: Simulation) -> tuple[str, ...]:
    """Greatest and last force with elastic-plastic contacts, in a sentence.

    Damped contacts and those with another law remain as they are. There is none for long chains, and if a contact that
    remains elastic yields: its damping stands for plastic flow.
    """
    chain = result.chain
    if chain.count is None or chain.count > _MOST or chain.packing:
        return ()
    options = SimulateOptions(rtol=_RTOL, until=result.options.until if result.wave is None else None)
    try:
        scene = Scene(excitation=result.scene.excitation, chain=plastic_chain(chain))
        plastic = simulate_chain(options, scene, result.computation, check_setup(options, scene))
    except ShockwaveError:  # the law does not cover these materials
        return ()
    if plastic.yielding is None or plastic.yielding.elastic_ratio > 1:
        return ()
    forces = {"greatest force": plastic.greatest_force.peak_force}
    forces |= {each.name: each.value or 0.0 for each in (plastic.leaving, plastic.leaving.spring) if each is not None}
    *texts, last = (f"the {name} is {si(force, 'N', _DIGITS)}" for name, force in forces.items())
    return (f"With elastic-plastic contacts, {', '.join(texts)}, and {last}.",)
