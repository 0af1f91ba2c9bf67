"""Commands of plugins."""

from __future__ import annotations

import argparse

from shockwave.base.errors import PluginError, ShockwaveError, UnknownNameError, UsageError, hint_of, text_of
from shockwave.cli.command_table import COMMANDS, OFFERED
from shockwave.registry.registry import describe, entries, find, load


def run(options: argparse.Namespace) -> int:
    """Run the command of a plugin; a name that no plugin registers is an error of usage."""
    try:
        entry = find("commands", options.name)
    except UnknownNameError:
        if plugin := OFFERED.get(options.name):
            remedy = f"in the source tree: python -m pip install ./plugins/{plugin}"
            raise UsageError(f"{options.name}: {plugin} must be installed and not disabled ({remedy})") from None
        names = [*dict.fromkeys([*(each.name for each in COMMANDS), *(each.name for each in entries("commands"))])]
        raise UsageError(f"unknown command (got {text_of(options.name)}; {hint_of(options.name, names)})") from None
    function = load("commands", options.name)
    try:
        return int(function(options.arguments) or 0)
    except (ShockwaveError, BrokenPipeError):
        raise
    except Exception as error:
        problem = f"must not raise (got {describe(error):.200})"
        raise PluginError(f"command {entry.name!r} of {entry.distribution}: {problem}") from error
