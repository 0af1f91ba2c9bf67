"""The command line: predict, simulate, compare, validate, list, new, schema.

Heavy imports stand inside the commands, so that help costs nothing and a prediction loads no simulator.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shockwave import __version__
from shockwave.errors import Fault, FileAccessError, PluginError, ScenarioError, ShockwaveError, UsageError

if TYPE_CHECKING:
    from shockwave.options import SimulateOptions
    from shockwave.scenario.load import Scenario

__all__ = ["main"]

_KINDS = ("profiles", "integrators", "backends", "quadratures", "materials", "models", "plugins")
_NO_PLUGINS = "use nothing but what is built in"
_EXITS = "exit status: 0 done; 1 a run failed; 2 usage; 3 invalid scenario; 4 faulty plugin; 5 file access"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; no exception leaves it."""
    options = _parser().parse_args(arguments)
    try:
        with _without_plugins() if options.no_plugins else nullcontext():
            status: int = options.command(options)
            sys.stdout.flush()
            return status
    except ShockwaveError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader of our output has gone; Python must not complain about it again on exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"the output cannot be written ({error.strerror or error})", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FileAccessError.exit_code
    except Exception as error:
        if os.environ.get("SHOCKWAVE_DEBUG"):
            raise
        print(
            f"internal error: {type(error).__name__}: {error} (SHOCKWAVE_DEBUG=1 shows where; please report it)",
            file=sys.stderr,
        )
        return 1


@contextmanager
def _without_plugins() -> Iterator[None]:
    """All plugins are disabled, here and in processes that are begun meanwhile."""
    from shockwave.registry import DISABLE, EVERY, forget

    before = os.environ.get(DISABLE)
    os.environ[DISABLE] = EVERY
    forget()
    try:
        yield
    finally:
        forget()
        os.environ.update({DISABLE: before or ""})


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="shockwave", description="Solitary waves in granular chains under shocks.", epilog=_EXITS
    )
    parser.add_argument("--version", action="version", version=f"shockwave {__version__}")
    parser.add_argument("--no-plugins", action="store_true", help=_NO_PLUGINS)
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    def command(name: str, run: Callable[[argparse.Namespace], int], summary: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=summary, description=summary, epilog=_EXITS)
        added.add_argument("--no-plugins", action="store_true", default=argparse.SUPPRESS, help=_NO_PLUGINS)
        added.set_defaults(command=run)
        return added

    for name, run, summary in (
        ("predict", _predict, "say a priori which waves a shock makes"),
        ("simulate", _simulate, "integrate the equations of motion and measure the waves"),
        ("compare", _compare, "prediction beside simulation"),
        ("validate", _validate, "check scenario files and tell every fault"),
    ):
        added = command(name, run, summary)
        added.add_argument("files", nargs="+", metavar="FILE", help="scenario file (YAML)")
        added.add_argument("--json", action="store_true", help="one JSON document on stdout")
        if name in ("simulate", "compare"):
            _add_simulate_options(added)
    listing = command("list", _list, "what is registered, built in and plugged in")
    listing.add_argument("kind", nargs="?", choices=_KINDS, help="only these")
    listing.add_argument("--json", action="store_true", help="one JSON document on stdout")
    listing.add_argument(
        "--check", action="store_true", help="import everything that plugins register, and tell faults"
    )
    new = command("new", _new, "write a scenario with every key and its meaning")
    new.add_argument("--profile", default="power-law", help="name of a profile (default: power-law)")
    schema = command("schema", _schema, "write a JSON Schema of scenarios, with what is installed, for editors")
    for added, kept in ((new, "which must not exist, "), (schema, "")):
        added.add_argument("-o", "--output", metavar="FILE", help=f"write to FILE, {kept}not to stdout")
    return parser


def _add_simulate_options(command: argparse.ArgumentParser) -> None:
    """What stands in place of the keys of the scenario's block ``simulate``."""
    command.add_argument("--rtol", type=_number("rtol"), help="relative error asked for")
    command.add_argument("--step", type=_number("step"), help="step of a method of fixed step, in natural times")
    command.add_argument("--integrator", help="name of a method; see `shockwave list integrators`")
    command.add_argument("--backend", choices=("auto", "compiled", "numpy"), help="which code steps the chain")
    command.add_argument("--contacts", type=_contacts, metavar="N,N", help="contacts whose passage is wanted")
    command.add_argument("--primary", action="store_true", help="the primary alone, not the whole train")


def _number(name: str) -> Callable[[str], float]:
    def parse(text: str) -> float:
        from attrs import fields_dict

        from shockwave.fields import quantity_of
        from shockwave.options import SimulateOptions

        spec = quantity_of(fields_dict(SimulateOptions)[name])
        try:
            value = float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"must be a number (got {text!r})") from None
        problem = spec.problem(value) if spec else None
        if problem:
            raise argparse.ArgumentTypeError(problem)
        return value

    return parse


def _contacts(text: str) -> tuple[int, ...]:
    try:
        contacts = tuple(int(part) for part in text.split(","))
    except ValueError:
        contacts = (-1,)
    if min(contacts) < 0:
        raise argparse.ArgumentTypeError(f"must be whole numbers from 0 on, such as 10,20 (got {text!r})")
    return contacts


def _scenarios(files: Sequence[str]) -> tuple[list[Scenario], int]:
    """All scenarios and 0; or, after every fault of every file was told, the greatest exit status of them."""
    from shockwave.scenario.load import load_scenario

    scenarios: list[Scenario] = []
    status = 0
    for file in files:
        try:
            scenarios.append(load_scenario(file))
        except ShockwaveError as error:
            print(error, file=sys.stderr)
            status = max(status, error.exit_code)
    return scenarios, status


def _run(
    options: argparse.Namespace,
    one: Callable[[Scenario], Any],
    several: Callable[[list[Any]], str],
) -> int:
    """Do ``one`` for every scenario and print the results; a failure is told and does not stop the others."""
    scenarios, status = _scenarios(options.files)
    if status:
        return status
    done: list[Any] = []
    documents: list[dict[str, Any]] = []
    for number, scenario in enumerate(scenarios, start=1):
        if sys.stderr.isatty():
            print(f"{number} of {len(scenarios)}: {scenario.name}", file=sys.stderr)
        try:
            result = one(scenario)
            # whatever the result leaves until it is looked at is looked at here
            document = result.to_dict()
        except ShockwaveError as error:
            print(f"{scenario.path}: {error}", file=sys.stderr)
            documents.append({"scenario": scenario.name, "error": str(error)})
            status = max(status, error.exit_code)
        except KeyboardInterrupt:
            print(f"{scenario.path}: interrupted; what was done before follows", file=sys.stderr)
            status = 130
            break
        else:
            done.append(result)
            documents.append(document)
    if options.json:
        if documents:
            _print_json(documents if len(options.files) > 1 else documents[0])
    elif len(options.files) == 1:
        for result in done:
            print(result)
    elif done:
        print(several(done))
    return status


def _print_json(document: object) -> None:
    print(json.dumps(document, indent=2, allow_nan=False))


def _predict(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.report import outcome_table

    def one(scenario: Scenario) -> Any:
        return evolve(scenario.predictor.predict(scenario.shock, scenario.chain), scenario=scenario.name)

    return _run(options, one, outcome_table)


def _simulate(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.measurement.simulate import simulate_with
    from shockwave.report import simulation_table

    def one(scenario: Scenario) -> Any:
        result = simulate_with(_settings(options, scenario), scenario.shock, scenario.chain)
        return evolve(result, scenario=scenario.name)

    return _run(options, one, simulation_table)


def _compare(options: argparse.Namespace) -> int:
    from attrs import evolve

    from shockwave.comparison import compare
    from shockwave.report import comparison_table

    def one(scenario: Scenario) -> Any:
        found = compare(scenario.shock, scenario.chain, scenario.predictor, _settings(options, scenario))
        return evolve(
            found,
            published=scenario.published,
            predicted=evolve(found.predicted, scenario=scenario.name),
            simulated=evolve(found.simulated, scenario=scenario.name),
        )

    return _run(options, one, comparison_table)


def _settings(options: argparse.Namespace, scenario: Scenario) -> SimulateOptions:
    """The scenario's block ``simulate``, with what the command line puts in its place."""
    from attrs import evolve

    names = ("rtol", "step", "integrator", "backend", "contacts")
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if options.primary:
        given["waves"] = "primary"
    # a method named here has a use for its own settings, not for those of the one that it replaces
    if "integrator" in given:
        given = {"rtol": None, "step": None} | given
    return evolve(scenario.simulate, **given)


def _validate(options: argparse.Namespace) -> int:
    from shockwave.scenario.load import load_scenario

    status, documents = 0, []
    for file in options.files:
        faults: tuple[Fault, ...] = ()
        try:
            load_scenario(file)
        except (ScenarioError, PluginError) as error:
            faults, status = error.faults or (Fault("", str(error)),), max(status, error.exit_code)
        except ShockwaveError as error:
            faults, status = (Fault("", str(error)),), max(status, error.exit_code)
        documents.append(
            {
                "file": file,
                "valid": not faults,
                "faults": [{"location": f.location, "path": f.path, "problem": f.problem} for f in faults],
            }
        )
        if not options.json:
            print(*(faults or [f"{file}: valid"]), sep="\n")
    if options.json:
        _print_json(documents if len(documents) > 1 else documents[0])
    return status


def _list(options: argparse.Namespace) -> int:
    if options.check and options.kind not in (None, "plugins"):
        raise UsageError("--check is for plugins: shockwave list plugins --check")
    kinds = [options.kind] if options.kind else list(_KINDS)
    document = {kind: _plugins(options.check) if kind == "plugins" else _listed(kind) for kind in kinds}
    if options.json:
        _print_json(document[options.kind] if options.kind else document)
    else:
        from shockwave.text import table

        for kind, found in document.items():
            rows = [(row["name"], row["summary"], row["distribution"]) for row in found]
            print(table((kind, "", "from"), rows) if rows else f"{kind}: none installed", end="\n\n")
            for row in found if kind == "plugins" else ():
                if row["problem"]:
                    print(f"{row['distribution']} is at fault: {row['problem']}", end="\n\n")
    faulty = options.check and any(row["problem"] for row in document["plugins"])
    return PluginError.exit_code if faulty else 0


def _plugins(check: bool) -> list[dict[str, Any]]:
    """A row for each installed plugin; ``check`` imports what it registers, in a process of its own."""
    from shockwave import registry

    rows = []
    for found in registry.plugins():
        plugin = registry.checked(found) if check else found
        names = ", ".join(entry.name for _, entry in plugin.entries)
        state = "disabled" if plugin.disabled else "AT FAULT" if plugin.problem else ""
        rows.append(
            {
                "name": plugin.distribution,
                "summary": "; ".join(part for part in (names, state) if part),
                "distribution": f"{plugin.distribution} {plugin.version}".rstrip(),
                "version": plugin.version,
                "entries": [{"kind": kind, "name": entry.name} for kind, entry in plugin.entries],
                "disabled": plugin.disabled,
                "checked": check and not plugin.disabled,
                "problem": plugin.problem or None,
            }
        )
    return rows


def _listed(kind: str) -> list[dict[str, Any]]:
    from shockwave import registry

    if kind == "backends":
        from shockwave.simulation.backend import BACKENDS, lack

        problems = {"compiled": lack() or None, "numpy": None}
        return [
            {"name": name, "summary": problems[name] or what, "distribution": "shockwave", "problem": problems[name]}
            for name, what in BACKENDS.items()
        ]
    return [
        {"name": entry.name, "summary": entry.summary, "distribution": entry.distribution}
        for entry in registry.entries(kind)
    ]


def _new(options: argparse.Namespace) -> int:
    from shockwave.scenario.template import template

    return _written(template(options.profile), options.output, anew=True)


def _schema(options: argparse.Namespace) -> int:
    from shockwave.scenario.schema import schema

    return _written(json.dumps(schema(), indent=2, allow_nan=False) + "\n", options.output, anew=False)


def _written(text: str, output: str | None, anew: bool) -> int:
    """Write ``text`` to the file ``output``, which ``anew`` must not exist, or to stdout."""
    if not output:
        print(text, end="")
        return 0
    try:
        with Path(output).open("x" if anew else "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        reason = "it exists already; choose another name" if isinstance(error, FileExistsError) else error.strerror
        raise FileAccessError(f"{output}: cannot be written ({reason})") from error
    print(f"{output}: written", file=sys.stderr)
    return 0
