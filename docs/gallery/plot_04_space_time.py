"""
Space-time map of a wave train
==============================

A long shock separates into a train of solitary waves: the strongest travels fastest.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=3), peak_force="20 N", rise_time="80 us"
)
result = sw.simulate(
    shock, chain, contacts=range(80), record=["forces"], wave_threshold=0.02
)
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

# %%
# What to see: the stronger a wave, the steeper its line in the map, and the farther
# apart the waves at each further contact.
