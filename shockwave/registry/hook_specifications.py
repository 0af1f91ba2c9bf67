"""Hooks of plugins: functions without arguments that return entries.

A distribution names one of its modules in the entry-point group ``shockwave``. That module contains one or more of the
functions below, marked with `hookimpl`, and must not import slow modules::

    from shockwave.hooks import Entry, hookimpl

    @hookimpl
    def shockwave_profiles():
        return [Entry("bell", "my_pulses.bell:Bell", "a power of a sine")]
"""

from __future__ import annotations

import pluggy

from shockwave.registry.built_ins import Entry

hookimpl = pluggy.HookimplMarker("shockwave")
_hookspec = pluggy.HookspecMarker("shockwave")


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
def shockwave_contacts() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of `ContactLaw` subclasses."""


@_hookspec
def shockwave_commands() -> list[Entry]:  # type: ignore[empty-body]
    """Addresses of functions that run a command: they take its arguments, a list of str, and return an exit status."""
