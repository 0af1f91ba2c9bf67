"""
The lightest protector for a limit
==================================

Which beads keep the force on the wall below a limit, within the available space,
with the least mass? The search simulates the options, ranks the materials and shows the
trade-off between force and mass.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(
    material="bearing-steel-52100",
    diameter="9.5 mm",
    granules=20,
    end=sw.Wall(material="rigid"),
)
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="20 N", rise_time="15 us"
)

result = sw.design(
    shock,
    chain,
    vary={
        "chain.diameter": ("12 mm", "25 mm"),
        "chain.material": ["polycarbonate", "delrin"],
    },
    target="transmitted.peak_force <= 9 N",
    budget="chain.length <= 0.4 m",
)
print(result)

# %%
# The line joins the options that no other one beats in both quantities.

result.plot()
plt.show()

# %%
# What to see: the star, beads of polycarbonate of 15.3 mm, is the lightest option below
# the dashed limit.
