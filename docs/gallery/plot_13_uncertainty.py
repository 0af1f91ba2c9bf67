"""
Uncertain beads, uncertain force
================================

Tolerances of radius and modulus and the scatter of the shock make the force of the
leading wave uncertain. Sobol indices show which of them matters most.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=4), peak_force="10 N", rise_time="30 us"
)
result = sw.uncertainty(
    shock,
    chain,
    {
        "chain.radius": "2 %",
        "chain.material.youngs_modulus": "5 %",
        "shock.peak_force": {"sd": "0.5 N"},
    },
    limit="14.5 N",
)
force = result.quantities[0]
print(f"{force.label}: mean {force.mean.value:.3f} N")
print(f"standard deviation {force.sd.value:.3f} N")

result.plot()
plt.show()

# %%
# The sources of the uncertainty of the force.

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
names = [each.name.rpartition(".")[2].replace("_", " ") for each in force.sensitivities]
ax.barh(names, [each.total.value for each in force.sensitivities])
ax.set(xlabel="share of the variance (total Sobol index)", xlim=(0, 1))
plt.show()

# %%
# What to see: the force scatters by about 6 %, and nearly all of it comes from the
# scatter of the blow, not from the beads.
