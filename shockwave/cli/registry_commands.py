"""The commands list, new and schema, which show what is registered."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from shockwave import OWN_DISTRIBUTION
from shockwave.cli.output import print_json, written
from shockwave.cli.parser import KINDS
from shockwave.errors import PluginError, UsageError

if TYPE_CHECKING:
    from shockwave.registry import Plugin


def list_registered(options: argparse.Namespace) -> int:
    if options.check and options.kind not in (None, "plugins"):
        raise UsageError("--check is for plugins: shockwave list plugins --check")
    kinds = [options.kind] if options.kind else KINDS
    document = {kind: _rows(kind, options.check) for kind in kinds}
    if options.json:
        print_json(document[options.kind] if options.kind else document)
    else:
        for kind, rows in document.items():
            _print(kind, rows)
    faulty = options.check and any(row["problem"] for row in document.get("plugins", ()))
    return PluginError.exit_code if faulty else 0


def _print(kind: str, rows: list[dict[str, Any]]) -> None:
    from shockwave.text import table

    cells = [(row["name"], row["summary"], row["distribution"]) for row in rows]
    print(table((kind, "", "from"), cells, margin=0) if rows else f"{kind}: none installed", end="\n\n")
    for row in rows if kind == "plugins" else ():
        if row["problem"]:
            print(f"{row['distribution']} is at fault: {row['problem']}", end="\n\n")


def _rows(kind: str, check: bool) -> list[dict[str, Any]]:
    from shockwave.plugin_check import checked_plugins
    from shockwave.registry import entries, plugins
    from shockwave.simulation.backend import BACKENDS, lack

    if kind == "plugins":
        return [_plugin(plugin, check) for plugin in (checked_plugins() if check else plugins())]
    if kind == "backends":
        problems = {"compiled": lack() or None, "numpy": None}
        return [
            {"name": name, "summary": problem or BACKENDS[name], "distribution": OWN_DISTRIBUTION, "problem": problem}
            for name, problem in problems.items()
        ]
    fields = ("name", "summary", "distribution")
    return [{field: getattr(entry, field) for field in fields} for entry in entries(kind)]


def _plugin(plugin: Plugin, check: bool) -> dict[str, Any]:
    names = ", ".join(entry.name for _, entry in plugin.entries)
    state = "disabled" if plugin.disabled else "AT FAULT" if plugin.problem else ""
    return {
        "name": plugin.distribution,
        "summary": "; ".join(filter(None, (names, state))),
        "distribution": f"{plugin.distribution} {plugin.version}",
        "version": plugin.version,
        "entries": [{"kind": kind, "name": entry.name} for kind, entry in plugin.entries],
        "disabled": plugin.disabled,
        "checked": check and not plugin.disabled,
        "problem": plugin.problem or None,
    }


def new(options: argparse.Namespace) -> int:
    from shockwave.scenario.template import template

    return written(template(options.profile), options.output, anew=True)


def schema(options: argparse.Namespace) -> int:
    from shockwave.scenario.schema import schema as of_scenarios

    return written(json.dumps(of_scenarios(), indent=2, allow_nan=False) + "\n", options.output)
