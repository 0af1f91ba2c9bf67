"""
Speed of waves under precompression
===================================

Without a static load a granular chain has no speed of sound: the speed of a wave scales
as the sixth root of its force. A static force brings a finite speed of sound (dotted),
which weak waves approach.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

steel = sw.material("bearing-steel-52100")
first, last = 30, 60
strengths = np.geomspace(1, 100, 7)

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for static in (0.0, 2.0, 20.0):
    chain = sw.Chain(
        material=steel, diameter="9.5 mm", granules=90, precompression=static
    )
    forces, speeds = [], []
    for strength in strengths:
        shock = sw.Shock(
            profile=sw.Triangular(duration_ratio=2),
            peak_force=strength,
            rise_time="10 us",
        )
        one, other = sw.simulate(
            shock, chain, contacts=[first, last], until=4e-3
        ).contacts
        forces.append(other.peak_force - static)
        speeds.append((last - first) * 9.5e-3 / (other.time - one.time))
    (line,) = ax.plot(forces, speeds, "o-", label=f"{static:g} N")
    if static:
        # long waves: c = 2 R sqrt(K/m) with K = (3/2) k^(2/3) F0^(1/3)
        stiffness = 1.5 * chain.contact_stiffness ** (2 / 3) * static ** (1 / 3)
        sound = 9.5e-3 * np.sqrt(stiffness / chain.granule_mass)
        ax.axhline(sound, color=line.get_color(), linestyle=":")
ax.set(
    xscale="log", xlabel="peak force above the static force (N)", ylabel="speed (m/s)"
)
ax.legend(title="precompression")
plt.show()

# %%
# What to see: without a static load stronger waves are faster everywhere. Under 20 N
# waves up to 10 N have nearly the speed of sound.
