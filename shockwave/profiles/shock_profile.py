"""The abstract shock profile: the shape of a shock, eq. (2), and its integrals."""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from itertools import pairwise
from types import MethodWrapperType
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.arguments import Explained
from shockwave.base.errors import PluginError
from shockwave.base.numerics import FloatArray, elementwise, floats
from shockwave.profiles.quadrature import Integral, Integrand, Quadrature
from shockwave.registry.plugin_check import guard, memoize
from shockwave.registry.registry import UNDECORATED, blame, lacks_decorator, load, owner_of

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath

    _Type = TypeVar("_Type")

    def _member(getter: Callable[[Any], _Type]) -> _Type:
        """A member that a subclass declares as a field or a property."""


_DEFAULT_QUADRATURE = "gauss-legendre"
# Relative rounding error of a closed form: a few units in the last place.
_ROUNDING = 4 * float(np.finfo(float).eps)


@frozen
class Areas:
    """Areas under the rise (a1) and the decay (a2) of a profile, in units of F0 t0, eq. (3)."""

    rise: Integral
    decay: Integral

    @property
    def total(self) -> float:
        """Impulse of the profile, a1 + a2, in units of F0 t0."""
        return self.rise.value + self.decay.value


class ShockProfile(Explained, abc.ABC):
    """The shape of a shock: force in units of its peak F0 against time s = t/t0 in units of its rise time.

    The force rises on [0, 1], decays on [1, n] and is zero elsewhere, eq. (2).

    Contract for implementers
    -------------------------
    1. ``duration_ratio`` is n, the total duration over the rise time, a number above 1: an attribute, a
       property or an attrs field. With attrs, every other field is a parameter of the profile.
    2. ``rise(s)`` is F1 on 0 <= s <= 1 and ``decay(s)`` is F2 on 1 <= s <= n. Both are vectorised: they take
       a float array of any shape and return one of the same shape. They are not called outside their range.
       Both are pure: the same s gives the same value, in any array and in every process.
    3. Values are finite, never negative, and at most 1; ``rise(1)`` and ``decay(1)`` are 1.
    4. ``breakpoints`` ascends from 0 to n and contains 1 and every s at which the force or one of its first few
       derivatives is discontinuous. The default is (0, 1, n).
    5. ``closed_areas`` and ``closed_running_impulse`` return None (the default: the integral is computed by
       quadrature) or the exact integral, accurate to a few units in the last place. ``closed_free_path`` returns None
       (the default: polynomials are fitted to the force) or the table of impulse and displacement on [0, n], as
       accurate.
    6. ``recorded_peak_force`` and ``recorded_rise_time`` are None (the default), or the peak force [N] and the rise
       time [s] of the measurement that the shape was read from.
    7. ``notes`` are sentences that state the changes made to the given data; none by default.

    A subclass overrides only these members; every other method is final. The values that a profile of a plugin or a
    script returns are checked when they are used; a violation raises a `PluginError`.
    """

    if TYPE_CHECKING:

        @_member
        def duration_ratio(self) -> float | Any: ...

    def __init__(self, *values: object, **named: object) -> None:
        # the constructor of subclasses without one, such as those that attrs has not decorated
        refused = (values or named) and isinstance(super().__init__, MethodWrapperType)
        rule = "must be decorated with attrs.frozen, or define __init__, to take arguments" if refused else ""
        if lacks_decorator(type(self)):
            rule = UNDECORATED
        if rule:
            raise PluginError(f"profile {owner_of('profiles', type(self))}: {rule}")
        super().__init__(*values, **named)  # of another base class

    @abc.abstractmethod
    def rise(self, s: FloatArray) -> FloatArray:
        """F1 of eq. (2): force over peak force on 0 <= s <= 1."""

    @abc.abstractmethod
    def decay(self, s: FloatArray) -> FloatArray:
        """F2 of eq. (2): force over peak force on 1 <= s <= n."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Values of s, from 0 to n in ascending order, at which the force is not smooth."""
        return (0.0, 1.0, self.duration_ratio)

    @property
    def recorded_peak_force(self) -> float | None:
        """Peak force of the underlying record [N]; None for a profile that is not a record."""
        return None

    @property
    def recorded_rise_time(self) -> float | None:
        """Rise time of the underlying record [s]; None for a profile that is not a record."""
        return None

    @property
    def pulls(self) -> bool:
        """Whether the force is negative somewhere; only a record can be, and only simulations cover it."""
        return False

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that state the changes made to the given data."""
        return ()

    def closed_areas(self) -> tuple[float, float] | None:
        """Exact areas (a1, a2) of eq. (3), or None."""
        return None

    def closed_running_impulse(self, s: FloatArray) -> FloatArray | None:
        """Exact integral of the force from 0 to s, 0 <= s <= n, or None; same shape as ``s``."""
        if self.closed_at(0.0) is None:
            return None
        return elementwise(lambda end: cast(tuple[float, float], self.closed_at(end))[0], s)

    def closed_free_path(self) -> FreePath | None:
        """Exact table of impulse and displacement on [0, n], or None."""
        return None

    def closed_at(self, s: float) -> tuple[float, float] | None:
        """Exact running impulse and force at one s, 0 <= s <= n, or None; only built-in profiles define it."""
        return None

    # ---------------------------------------------------------------- final methods

    def force(self, s: npt.ArrayLike) -> FloatArray:
        """Force over peak force at any s, zero outside [0, n], NaN for NaN; same shape as ``s``."""
        s = floats("s", s)
        rising = (s >= 0) & (s <= 1)
        decaying = (s > 1) & (s <= self.duration_ratio)
        result = np.where(np.isnan(s), s, 0.0)
        result[rising] = guard(self, "rise", s[rising])
        result[decaying] = guard(self, "decay", s[decaying])
        return result

    def areas(self, quadrature: str | None = None) -> Areas:
        """Areas under rise and decay, a1 and a2 of eq. (3).

        Parameters
        ----------
        quadrature : str, optional
            Name of a registered quadrature, which is used even where a closed form exists. By default the closed form
            is used where there is one, otherwise Gauss-Legendre.

        Raises
        ------
        UnknownNameError
            If no quadrature has this name.
        """
        closed = self.closed_areas() if quadrature is None else None
        if closed is None:
            return _integrate_areas(self, quadrature)
        return Areas(*[Integral(area, _ROUNDING * abs(area), 0, "closed form") for area in closed])

    @property
    def total_area(self) -> float:
        """Impulse of the profile, a1 + a2, in units of F0 t0."""
        closed = self.closed_areas()
        return self.areas().total if closed is None else closed[0] + closed[1]

    def running_impulse(self, s: npt.ArrayLike, quadrature: str | None = None) -> FloatArray:
        """Integral of the force from 0 to ``s``, in units of F0 t0; constant before 0 and after n.

        ``quadrature`` as in `areas`. Same shape as ``s``.
        """
        inside: FloatArray = np.clip(np.asarray(s, dtype=float), 0.0, self.duration_ratio)
        closed = self.closed_running_impulse(inside) if quadrature is None else None
        if closed is not None:
            return closed
        # Each interval between ends is integrated once; all sums are of positive numbers.
        points, places = np.unique(np.append(0.0, inside), return_inverse=True)
        pieces = [self.integral(begin, end, quadrature).value for begin, end in pairwise(points.tolist())]
        return np.cumsum([0.0, *pieces])[places.ravel()[1:]].reshape(inside.shape)

    def free_path(self) -> FreePath:
        """Free-particle displacement and running impulse on [0, n] as a table, for evaluation at many s.

        Raises
        ------
        NumericalError
            If the force is not finite somewhere.
        """
        closed = self.closed_free_path()
        return _fit(self) if closed is None else closed

    def integral(self, begin: float, end: float, quadrature: str | None, double: bool = False) -> Integral:
        """Impulse from ``begin`` to ``end``, or with ``double`` its integral, 0 <= begin <= end <= n, by quadrature."""
        points = [begin, *(p for p in self.breakpoints if begin < p < end), end]
        # Cauchy's formula for repeated integration avoids the difference of large numbers.
        integrand = (lambda s: (end - s) * self.force(s)) if double else self.force
        return _integrate(quadrature, integrand, points)


@memoize
def _integrate_areas(profile: ShockProfile, quadrature: str | None) -> Areas:
    before = [p for p in profile.breakpoints if p <= 1]
    after = [p for p in profile.breakpoints if p >= 1]
    return Areas(_integrate(quadrature, profile.force, before), _integrate(quadrature, profile.force, after))


@memoize
def _fit(profile: ShockProfile) -> FreePath:
    # Imported late because only simulations need it.
    from shockwave.profiles.free_path import fit_free_path

    return fit_free_path(profile.force, profile.breakpoints)


def _integrate(name: str | None, integrand: Integrand, points: Sequence[float]) -> Integral:
    method: type[Quadrature] = load("quadratures", name or _DEFAULT_QUADRATURE)
    with blame("quadratures", method):
        return method().integrate(integrand, points)
