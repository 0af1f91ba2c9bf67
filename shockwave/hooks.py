"""Hooks of plugins: functions without arguments that return entries.

A distribution names one of its modules in the entry-point group ``shockwave``. That module contains one or more of the
functions below, marked with `hookimpl`, and must not import slow modules::

    from shockwave.hooks import Entry, hookimpl

    @hookimpl
    def shockwave_profiles():
        return [Entry("half-sine", "shockwave_pulses.half_sine:HalfSine", "half a period of a sine")]
"""

from __future__ import annotations

from typing import NamedTuple

import pluggy

hookimpl = pluggy.HookimplMarker("shockwave")
_hookspec = pluggy.HookspecMarker("shockwave")


class Entry(NamedTuple):
    """A registered object: its ``name``, its ``address`` (``package.module:attribute``) and a ``summary`` in one line.

    ``takes`` lists the settings that it uses, if they differ within its kind: for an integrator ``rtol`` if it is
    adaptive and ``step`` otherwise; for a model ``alpha`` and ``rtol``, if it uses them. The registry sets
    ``distribution``.
    """

    name: str
    address: str
    summary: str
    distribution: str = ""
    takes: str = ""


@_hookspec
def shockwave_profiles() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of `ShockProfile` subclasses."""


@_hookspec
def shockwave_integrators() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of `Integrator` subclasses."""


@_hookspec
def shockwave_quadratures() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of `Quadrature` subclasses."""


@_hookspec
def shockwave_materials() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of `Material` objects."""


@_hookspec
def shockwave_models() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of prediction models, functions of a scaled shock."""
