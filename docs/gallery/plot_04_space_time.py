"""
Space-time map of a wave train
==============================

A long shock separates into a train of solitary waves: the strongest travels fastest.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

chain = sw.Chain(material="stainless-steel-302", diameter="9.5 mm")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="20 N", rise_time="80 us"
)
result = sw.simulate(shock, chain, contacts=range(80), record=["forces"])
for wave in result.waves[:4]:
    print(f"{wave.peak_force:8.3f} N  {wave.speed:6.1f} m/s")

# %%
# The dashed lines are the fronts of the measured waves.

pictures.space_time(result)
plt.show()

# %%
# The same train as force against time at three contacts.

pictures.contact_forces(result, contacts=[10, 40, 79])
plt.show()
