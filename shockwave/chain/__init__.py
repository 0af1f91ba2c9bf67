"""The chain of equal elastic spheres: material, contact law, scaled units, and its solitary wave."""

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import SolitaryWave

__all__ = ["Chain", "Material", "Scales", "SolitaryWave"]
