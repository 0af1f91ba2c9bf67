"""
Ranking of materials
====================

The same shock on beads of several materials of the library: soft and heavy granules
transmit the least force, hard and light ones the most. The blow is so weak that no bead
yields.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="5 N", rise_time="80 us"
)
names = [
    *("stainless-steel-302", "aluminium-6061-t6", "brass-260", "titanium-ti-6al-4v"),
    *("tungsten", "tungsten-carbide", "alumina", "soda-lime-glass"),
    *("delrin", "nylon-66", "pmma", "polycarbonate"),
]
chains = [sw.Chain(material=sw.material(name), diameter="25.4 mm") for name in names]
results = sw.simulate_many([shock] * len(chains), chains, waves="primary")

ranked = sorted(zip(names, results, strict=True), key=lambda pair: pair[1].peak_force)
figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
ax.barh([name for name, _ in ranked], [result.peak_force for _, result in ranked])
ax.axvline(5, color="k", linestyle="--", linewidth=0.8)
ax.set(xlabel="peak force of the leading wave (N)")
plt.show()

# %%
# What to see: polymer beads transmit about half of the peak force of the shock
# (dashed), alumina beads more than all of it.
