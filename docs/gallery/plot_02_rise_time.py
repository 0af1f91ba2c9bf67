"""
Sweep of the rise time
======================

A short shock is attenuated by the first granules; a long one generates waves stronger
than itself. Section 4 of the paper is close to the simulation in between.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
profile = sw.Triangular(duration_ratio=3)
times = np.geomspace(2e-6, 500e-6, 25)
shocks = [sw.Shock(profile=profile, peak_force=10.0, rise_time=time) for time in times]

results = sw.Predictor().predict_many(shocks, chain)

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for name, outcomes, line in (
    ("simulation", results, ".-"),
    ("section 4", [result.section4 for result in results], "--"),
):
    forces = [outcome.amplification for outcome in outcomes]
    ax.plot(1e6 * times, forces, line, color=pictures.METHODS[name], label=name)
ax.axhline(1, color="grey", linewidth=0.8)
ax.set(xscale="log", xlabel="rise time (µs)", ylabel="leading wave over shock")
ax.legend()
plt.show()

# %%
# What to see: blows that rise in less than 23 µs are weakened, longer ones amplified up
# to more than twice. Section 4 is close from about 13 to 32 µs.
