"""Short scenarios, as text."""

CHAIN = "chain: {material: copper, radius: 1 mm}\n"
SHOCK = "shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}\n"
TABULATED = CHAIN + "shock: {profile: tabulated, parameters: {%s}}\n"
