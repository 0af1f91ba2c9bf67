"""The scene: a shock or an impact on a chain of elastic spheres, with materials, contact laws and end."""
