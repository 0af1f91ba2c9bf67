"""
From a record to a verdict
==========================

A measured force, here a noisy half-sine, becomes a shock. The force behind the beads is
compared with a limit.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

# the record of a load cell: 25 N in 120 us, sampled every 2 us, with noise
times = np.arange(0, 121) * 2e-6
noise = np.random.default_rng(3).normal(0, 0.1, times.shape)
forces = np.where(times < 120e-6, 25 * np.sin(np.pi * times / 120e-6), 0) + noise
end = int(np.argmax(times >= 120e-6))
record = sw.Tabulated(
    times=times[: end + 1], forces=np.clip(forces[: end + 1], 0, None)
)

chain = sw.Chain(
    material="bearing-steel-52100",
    diameter="12 mm",
    granules=60,
    end=sw.Wall(material="rigid"),
)
shock = sw.Shock(profile=record)

limit = sw.Limit(force="70 N")
simulated = sw.simulate(shock, chain, record=["forces"], limit=limit)
print(simulated.verdict)

# %%
# The force on the wall with the limit, and the record with its areas of rise and decay.

pictures.wall_force(simulated)
pictures.pulse(shock)
plt.show()

# %%
# What to see: a blow of 25 N becomes a force of 88 N on the wall, above the limit,
# because the chain amplifies long blows and the rigid wall more than doubles them.
