"""
Sweep of the rise time
======================

A short shock is weaker after the first granules, a long one generates waves stronger than itself. The estimate of a
prediction covers both, with a range; simulations confirm it.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw

chain = sw.Chain(material="stainless-steel-302", diameter="9.5 mm")
profile = sw.Triangular(duration_ratio=3)
times = np.geomspace(2e-6, 500e-6, 25)
shocks = [sw.Shock(profile=profile, peak_force=10.0, rise_time=time) for time in times]

results = sw.simulate_many(shocks, chain, waves="primary")
estimates = [sw.predict(shock, chain).estimate for shock in shocks]

figure, ax = plt.subplots(figsize=(6, 3.6), layout="constrained")
low, high = ([getattr(one, end) / 10 for one in estimates] for end in ("low", "high"))
ax.fill_between(1e6 * times, low, high, alpha=0.3, label="range of the estimate")
ax.plot(1e6 * times, [one.peak_force / 10 for one in estimates], label="estimate")
ax.plot(1e6 * times, [one.amplification for one in results], "k.", label="simulation")
ax.axhline(1, color="grey", linewidth=0.8)
ax.set(xscale="log", xlabel="rise time (µs)", ylabel="leading wave over shock")
ax.legend()
plt.show()
