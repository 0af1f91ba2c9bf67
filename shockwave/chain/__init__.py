"""Chains of elastic spheres: materials, segments, ends, contact laws, scaled units, and the solitary wave."""

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import SolitaryWave

__all__ = ["Chain", "Material", "Scales", "SolitaryWave"]
