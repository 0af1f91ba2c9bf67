"""
Mass of a striker
=================

A striker generates one wave if its mass is below 1.22 granules, apart from waves below
0.4 % of it. A heavier one generates a train: the heavier, the more waves. Below
1.8 granules it rebounds, with 7 % of its velocity if it is like them.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

ratios = np.geomspace(0.1, 100, 300)
waves = sw.striker_waves(ratios)

steel = sw.material("bearing-steel-52100")
chain = sw.Chain(material=steel, radius="5 mm", granules=60)
mass, stiffness, speed = chain.granule_mass, chain.contact_stiffness, 0.1
unit = (mass**3 * stiffness**2 * speed**6) ** 0.2

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for number, line in enumerate(("-", "--", "-.", ":", "-", "--")):
    shown = np.where(waves[:, number] > 0, waves[:, number], np.nan)
    ax.plot(ratios, shown, line, label=f"wave {number + 1}")
# the size of the striker changes its contact, too, which the law does not contain
for ratio in (0.3, 1, 3, 10):
    striker = sw.Impact(velocity=speed, radius=chain.radius * ratio ** (1 / 3))
    result = sw.simulate(striker, chain, contacts=[45])
    ax.plot(ratio, result.contacts[0].peak_force / unit, "ko")
ax.set(
    xscale="log",
    xlabel="mass of the striker over that of a granule",
    ylabel="peak force, scaled",
)
ax.legend()
plt.show()

# %%
# What to see: a second wave from a mass of 1.22 granules on, then one after the other.
# The dots, simulations of the leading wave, lie near the law.
