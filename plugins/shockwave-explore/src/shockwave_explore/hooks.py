"""The entry that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_commands() -> list[Entry]:
    return [Entry("explore", "shockwave_explore.server:explore", "open a page with sliders in the browser")]
