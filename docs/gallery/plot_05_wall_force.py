"""
Force on a wall against its stiffness
=====================================

A solitary wave exerts on a wall W times its own peak force. The law W depends on kappa
alone, the stiffness of the contact with the wall over that of the other contacts. It is
compared with simulated chains in front of walls of several materials.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

steel = sw.material("bearing-steel-52100")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=2), peak_force="10 N", rise_time="5 us"
)
wave = sw.simulate(
    shock, sw.Chain(material=steel, diameter="9.5 mm"), waves="primary"
).peak_force

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
kappa = np.linspace(0, 2 * np.sqrt(2), 400)
ax.plot(kappa, sw.wall_factor(kappa), "k", label="law")
soft, hard = ("delrin", "pmma"), ("soda-lime-glass", "titanium-ti-6al-4v", "rigid")
for name, marker in zip((*soft, *hard, "tungsten-carbide"), "os^DvP", strict=True):
    wall = sw.Wall(material=name)
    chain = sw.Chain(material=steel, diameter="9.5 mm", granules=60, end=wall)
    ratio = sw.simulate(shock, chain).transmitted.peak_force / wave
    ax.plot(wall.stiffness_ratio(steel), ratio, marker, label=name)
ax.set(
    xlabel=r"stiffness ratio $\kappa$",
    ylabel="peak force on the wall / peak force of the wave",
    ylim=(0, None),
)
ax.legend()
plt.show()

# %%
# What to see: walls of all materials lie on the curve of the law, from a soft one that
# hardly resists to a rigid one with 2.24 times the force of the wave.
