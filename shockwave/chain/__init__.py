"""The chain: equal elastic spheres, their contact law, scales, and the solitary wave that they carry."""

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import SolitaryWave

__all__ = ["Chain", "Material", "Scales", "SolitaryWave"]
