"""Forces with elastic-plastic contacts, as advice on a chain that is elastic beyond first yield."""

from __future__ import annotations

from attrs import evolve

from shockwave.base.errors import ShockwaveError
from shockwave.base.text import si
from shockwave.scene.contact_law import ElasticPlastic
from shockwave.scene.scene import Scene
from shockwave.scene.segments import each_segment
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_forces import simulate_chain
from shockwave.simulation.contact_setup import check_setup
from shockwave.simulation.simulation_result import Simulation

# Longest chain that is simulated for a sentence, and the tolerance and digits of its forces.
_MOST = 100
_RTOL = 1e-3
_DIGITS = 3


def value_with_yield(result: Simulation) -> tuple[str, ...]:
    """Greatest and last force with elastic-plastic contacts, in a sentence; none for long chains or other laws."""
    chain = result.chain
    laws = [part for _, each in each_segment(chain.granules) for part in (each.contact, each.damping)]
    if chain.count is None or chain.count > _MOST or any([chain.contact, chain.damping, chain.packing, *laws]):
        return ()
    scene = Scene(excitation=result.scene.excitation, chain=evolve(chain, contact=ElasticPlastic()))
    options = SimulateOptions(rtol=_RTOL, until=result.options.until)
    try:
        plastic = simulate_chain(options, scene, result.computation, check_setup(options, scene))
    except ShockwaveError:  # the law does not cover these materials
        return ()
    forces = {"greatest force": plastic.greatest_force.peak_force}
    forces |= {each.name: each.value or 0.0 for each in (plastic.leaving, plastic.leaving.spring) if each is not None}
    *texts, last = (f"the {name} is {si(force, 'N', _DIGITS)}" for name, force in forces.items())
    return (f"With elastic-plastic contacts {', '.join(texts)}, and {last}.",)
