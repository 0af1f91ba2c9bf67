"""
A tapered chain as a protector
==============================

In a chain of beads of decreasing size, each collision transmits only part of the
momentum at once: the force at the end is weaker and arrives later than behind equal
beads. The greatest force at each contact shows where it drops.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

steel = sw.material("bearing-steel-52100")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="10 N", rise_time="10 us"
)

forces = {}
for ratio in (1.0, 0.8, 0.6, 0.4):
    taper = sw.Taper(first="9.5 mm", last=ratio * 9.5e-3, spacing="geometric")
    chain = sw.Chain(
        material=steel,
        diameter="9.5 mm",
        granules=[sw.Segment(count=20, diameter=taper)],
        end=sw.Wall(material="rigid"),
    )
    result = sw.simulate(shock, chain, until=3e-3)
    forces[ratio] = result.transmitted
    print(
        f"last bead {ratio:.0%} of the first: "
        f"{result.transmitted.peak_force:.3f} N on the wall"
    )

# %%
# The force on the wall against the taper.

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
ax.plot(
    [100 * ratio for ratio in forces], [one.peak_force for one in forces.values()], "o-"
)
ax.set(
    xlabel="last bead over first bead (%)",
    ylabel="force on the wall (N)",
    ylim=(0, 10),
)
plt.show()

# %%
# The most tapered chain, with the greatest force at every contact.

result.plot()
plt.show()

# %%
# What to see: if the last bead has 40 % of the first one's diameter, the force on the
# wall is lower by a third. Each contact takes only a little of it.
