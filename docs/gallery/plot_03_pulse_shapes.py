"""
Triangle and half-sine
======================

Two pulses of the same peak force and duration. As long as the pulse is short, only
its impulse counts, and the half-sine gives a larger force; the ratio of the forces is
that of the areas to the power 6/5. For a long pulse the shape matters.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
profiles = {"triangle": sw.Triangular(duration_ratio=2), "half-sine": sw.HalfSine()}

rises = np.geomspace(2e-6, 300e-6, 21)
forces = {}
for name, profile in profiles.items():
    shocks = [
        sw.Shock(profile=profile, peak_force=10.0, rise_time=rise) for rise in rises
    ]
    results = sw.simulate_many(shocks, chain, waves="primary")
    forces[name] = [result.peak_force for result in results]

ratio = np.array(forces["half-sine"]) / forces["triangle"]
print(f"shortest pulse: {ratio[0]:.4f}, limit (4/pi)^(6/5) = {(4 / np.pi) ** 1.2:.4f}")

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for (name, values), line in zip(forces.items(), ("-", "--"), strict=True):
    ax.loglog(2e6 * rises, values, line, label=name)
ax.set(xlabel="duration (µs)", ylabel="leading wave (N)")
ax.legend()
plt.show()

# %%
# The ratio of the two, with its limit for short pulses.

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
ax.semilogx(2e6 * rises, ratio)
ax.axhline((4 / np.pi) ** 1.2, color="grey", linestyle="--")
ax.set(xlabel="duration (µs)", ylabel="half-sine over triangle")
plt.show()

# %%
# What to see: up to a duration of about 40 µs the ratio has its limit, and only the
# impulse counts. For longer pulses the two shapes come closer.
