"""Names for authors of plugins and their modules, for type checkers; `hooks.py` imports a name at its first use."""

from shockwave.base.numerics import FloatArray as FloatArray
from shockwave.engine.integrator import Acceleration as Acceleration
from shockwave.engine.integrator import Integrator as Integrator
from shockwave.engine.integrator import Step as Step
from shockwave.engine.one_step import Attempt as Attempt
from shockwave.engine.one_step import OneStep as OneStep
from shockwave.profiles.free_path import FreePath as FreePath
from shockwave.profiles.quadrature.base import Integral as Integral
from shockwave.profiles.quadrature.base import Integrand as Integrand
from shockwave.profiles.quadrature.base import Quadrature as Quadrature
from shockwave.registry.built_ins import Entry as Entry
from shockwave.registry.hook_specifications import hookimpl as hookimpl
from shockwave.scene.contact_law import Pairs as Pairs
