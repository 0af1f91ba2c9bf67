"""
A granular container of steel and Delrin
========================================

Soft beads between hard ones trap the pulse: it leaks out of them bit by bit, and the
wall receives several weak pulses instead of a strong one.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

steel, delrin = sw.material("bearing-steel-52100"), sw.material("delrin")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="5 N", rise_time="20 us"
)


def container(soft):
    """Thirty beads before a rigid wall, of which ``soft`` in the middle are Delrin."""
    hard = (30 - soft) // 2
    middle = [sw.Segment(count=soft, material=delrin)] if soft else []
    return sw.Chain(
        material=steel,
        diameter="9.5 mm",
        granules=[sw.Segment(count=hard), *middle, sw.Segment(count=30 - soft - hard)],
        end=sw.Wall(material="rigid"),
    )


figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for soft, line in ((0, "-"), (4, "--"), (10, ":")):
    result = sw.simulate(shock, container(soft), record=["forces"], until=2.8e-3)
    kept = result.recording
    ax.plot(1e3 * kept.times, kept.wall_force, line, label=f"{soft} beads of Delrin")
ax.set(xlabel="time (ms)", ylabel="force on the wall (N)")
ax.legend()
plt.show()

# %%
# Contact force over time and contacts.

pictures.chain_map(result)
plt.show()

# %%
# What to see: with ten beads of Delrin the peaks at the wall arrive later, and within
# the time shown none reaches half of the peak force behind steel alone.
