"""
A first prediction
==================

The leading wave of a triangular blow on steel beads, and what section 4 of the paper
predicts for it.
"""

import matplotlib.pyplot as plt

import shockwave as sw
from shockwave import pictures

plt.style.use(["default", pictures.style()])

chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
shock = sw.Shock(
    profile=sw.Triangular(duration_ratio=4), peak_force="10 N", rise_time="30 us"
)

outcome = sw.predict(shock, chain)
print(f"leading wave {outcome.peak_force:.5f} N")
print(f"between {outcome.low:.6f} and {outcome.high:.6f} N")
paper = outcome.section4
print(f"section 4 {paper.peak_force:.2f} N, error {paper.error:+.1%}, {outcome.regime}")

# %%
# The waves that the shock generates, by simulation and by section 4.

sw.compare(shock, chain).plot()
plt.show()

# %%
# The shock with its areas of rise and decay.

pictures.pulse(shock)
plt.show()

# %%
# What to see: the leading wave is a third stronger than the shock. Section 4 is 2 %
# below it and gives the second wave too strong.
