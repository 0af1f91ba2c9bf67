"""
Decay in viscoelastic granules
==============================

With the damping of Kuwabara and Kono a wave decays from contact to contact. The decay
law depends on one number, the time A of the model over the characteristic time of the
wave.
"""

import matplotlib.pyplot as plt
import numpy as np

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

delrin = sw.material("delrin")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=2), peak_force="5 N", rise_time="30 us"
)
passed = np.arange(0, 41)

figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for time in (0.2e-6, 0.5e-6, 1e-6):
    damping = sw.KuwabaraKono(time=time)
    chain = sw.Chain(material=delrin, diameter="9.5 mm", granules=80, damping=damping)
    result = sw.simulate(shock, chain, contacts=[15 + int(n) for n in passed])
    forces = np.array([one.peak_force for one in result.contacts])
    unit = (
        np.sqrt(chain.granule_mass)
        / chain.contact_stiffness ** (1 / 3)
        / forces[0] ** (1 / 6)
    )
    (line,) = ax.plot(
        passed, sw.damped_decay(passed, time / unit), label=f"A = {1e6 * time:g} µs"
    )
    ax.plot(passed[::4], (forces / forces[0])[::4], "o", color=line.get_color())
ax.set(xlabel="contacts passed", ylabel="peak force over the first", ylim=(0, 1.05))
ax.legend(title="law (lines), simulation (dots)")
plt.show()

# %%
# What to see: the longer the damping time, the faster the decay. The law and the
# simulation agree at all contacts.
