"""The commands list, new and schema."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from shockwave import OWN_DISTRIBUTION
from shockwave.base.errors import PluginError, UsageError
from shockwave.base.result import VERSION
from shockwave.base.text import alarm, paragraph, strong, table
from shockwave.cli.command_table import KINDS
from shockwave.cli.output import json_text, report_name_as_usage, write_output
from shockwave.engine.backend import BACKENDS, lack
from shockwave.registry.registry import Plugin, check_plugin, entries, plugins


def list_registered(options: argparse.Namespace) -> int:
    if options.check and options.kind not in (None, "plugins"):
        remedy = "use shockwave list plugins --check"
        raise UsageError(f"--check: can be used only with plugins (got {options.kind}; {remedy})")
    kinds = [options.kind] if options.kind else KINDS
    document = {kind: _rows(kind, options.check) for kind in kinds}
    if options.json:
        print(json_text(document[options.kind] if options.kind else VERSION | document))
    else:
        print("\n\n".join(_text(kind, rows) for kind, rows in document.items()))
    faulty = options.check and any(row["problem"] for row in document.get("plugins", ()))
    return PluginError.exit_code if faulty else 0


def _text(kind: str, rows: list[dict[str, Any]]) -> str:
    """Table of what is registered; below it, in full, the problems of plugins."""
    if not rows:
        return f"{kind}: none installed"
    if kind != "plugins":
        parts = [(row["name"], row["summary"], row["distribution"].replace(OWN_DISTRIBUTION, "")) for row in rows]
        # the origin matters only if there are plugins
        shown = 3 if any(part[2] for part in parts) else 2
        return table((strong(kind), "", "plugin")[:shown], [part[:shown] for part in parts], margin=0)
    cells, problems = [], []
    for row in rows:
        state = "disabled" if row["disabled"] else "checked" if row["checked"] else "enabled"
        cells.append(
            (row["name"], _names(row["entries"]), alarm("FAULTY") if row["problem"] else state, row["version"])
        )
        if row["problem"]:
            problems += ["", *map(alarm, paragraph("", f"{row['distribution']} is faulty: {row['problem']}", 2))]
    return "\n".join([table((strong(kind), "registers", "state", "version"), cells, margin=0), *problems])


def _names(entries: list[dict[str, str]]) -> str:
    return ", ".join(entry["name"] for entry in entries)


def _rows(kind: str, check: bool) -> list[dict[str, Any]]:
    if kind == "plugins":
        return [_plugin(plugin, check) for plugin in (map(check_plugin, plugins()) if check else plugins())]
    if kind == "backends":
        problems = {"compiled": lack() or None, "numpy": None}
        return [
            {"name": name, "summary": problem or BACKENDS[name], "distribution": OWN_DISTRIBUTION, "problem": problem}
            for name, problem in problems.items()
        ]
    fields = ("name", "summary", "distribution")
    return [{field: getattr(entry, field) for field in fields} for entry in entries(kind)]


def _plugin(plugin: Plugin, check: bool) -> dict[str, Any]:
    registered = [{"kind": kind, "name": entry.name} for kind, entry in plugin.entries]
    state = "disabled" if plugin.disabled else "faulty" if plugin.problem else ""
    return {
        "name": plugin.distribution,
        "summary": "; ".join(filter(None, (_names(registered), state))),
        "distribution": f"{plugin.distribution} {plugin.version}".rstrip(),
        "version": plugin.version,
        "entries": registered,
        "disabled": plugin.disabled,
        "checked": check and not plugin.disabled,
        "problem": plugin.problem or None,
    }


def new(options: argparse.Namespace) -> int:
    from shockwave.scenario.template import example, template

    if options.example and (options.full or options.profile):
        raise UsageError("--example: must be the only option besides --output (delete --full or --profile)")
    files = example(options.example) if options.example else {}
    with report_name_as_usage("--profile"):
        text = files.pop(f"{options.example}.yaml", None) or template(options.profile, options.full)
    status = write_output(text, options.output, anew=True)
    if options.output not in (None, "-"):
        files["scenario.schema.json"] = _schema()
    for name, content in files.items():
        # files that the scenario refers to; an existing one may be the user's
        path = Path(options.output or name).with_name(name)
        if not path.exists():
            write_output(content, str(path))
        else:
            print(f"{path}: exists, not changed", file=sys.stderr)
    return status


def schema(options: argparse.Namespace) -> int:
    return write_output(_schema(), options.output)


def _schema() -> str:
    from shockwave.scenario.schema import schema as of_scenarios

    return json_text(of_scenarios()) + "\n"
