"""What a plugin registers: nouns, by hooks that take nothing and return entries.

A distribution names a module of its own under the entry-point group ``shockwave``. That module holds one or
more of the functions below, marked with `hookimpl`, and should import nothing heavy::

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
    """A registered noun: its ``name``, its ``address`` (``package.module:attribute``) and one line on it.

    ``takes`` names the settings that it has a use for, where not all of its kind have the same: of an integrator
    ``rtol`` if it is adaptive, ``step`` if not; of a model ``alpha`` if it has one to choose, ``rtol`` if it chooses by
    it. ``distribution`` is filled in by the registry.
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
