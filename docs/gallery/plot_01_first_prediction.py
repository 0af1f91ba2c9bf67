"""
A first prediction
==================

The estimate of the leading wave and the simulation that checks it, for a triangular blow on steel beads.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

chain = sw.Chain(material="stainless-steel-302", diameter="9.5 mm")
shock = sw.Shock(profile=sw.Triangular(duration_ratio=4), peak_force="10 N", rise_time="30 us")

estimate = sw.predict(shock, chain).estimate
result = sw.simulate(shock, chain)
print(f"estimate  {estimate.peak_force:.3f} N, range {estimate.low:.3f} to {estimate.high:.3f} N")
print(f"simulated {result.peak_force:.6f} N, relative error at most {result.error_estimate:.0e}")

# %%
# The shock with its areas of rise and decay, and the waves that it generates.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
pictures.pulse(left, shock)
pictures.train(right, sw.compare(shock, chain))
plt.show()
