"""
A profile of one's own
======================

Any pulse given by a formula can be written as a class with two functions. Prediction,
simulation, pictures and studies accept it like a built-in profile.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from attrs import frozen

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])


@frozen(kw_only=True)
class Bell(sw.ShockProfile):
    """F1 = sin^p(pi s/2), F2 = cos^p(pi/2 (s-1)/(n-1))."""

    power: float = sw.quantity(
        "", "p, power of the sine", default=2, at_least=0.1, at_most=100
    )
    duration_ratio: float = sw.quantity("", "n, total duration over rise time", above=1)

    def rise(self, s):
        return np.sin(math.pi / 2 * s) ** self.power

    def decay(self, s):
        return self.rise((self.duration_ratio - s) / (self.duration_ratio - 1))


chain = sw.Chain(material="bearing-steel-52100", diameter="10 mm")
figure, ax = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
for power, line in ((1, "-"), (2, "--"), (4, ":")):
    bell = Bell(power=power, duration_ratio=2)
    shock = sw.Shock(profile=bell, peak_force="10 N", rise_time="60 us")
    print(f"p = {power}: leading wave {sw.predict(shock, chain).peak_force:.4f} N")
    s = np.linspace(0, 2, 300)
    forces = 10 * np.where(s < 1, bell.rise(s), bell.decay(s))
    ax.plot(60 * s, forces, line, label=f"$p$ = {power}")
ax.set(xlabel="time (µs)", ylabel="force (N)")
ax.legend()
plt.show()

# %%
# The waves that the steepest one generates.

sw.compare(shock, chain).plot()
plt.show()

# %%
# What to see: the narrower the pulse, the less impulse it has, and the weaker is the
# wave.
