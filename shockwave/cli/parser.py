"""The commands and their options."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from shockwave import __version__

__all__ = ["KINDS", "parser"]

KINDS = ("profiles", "integrators", "backends", "quadratures", "materials", "models", "plugins")
_NO_PLUGINS = "use nothing but what is built in"
_EXITS = "exit status: 0 done; 1 a run failed; 2 usage; 3 invalid scenario; 4 faulty plugin; 5 file access"
# Adds a command of a name, where it lives and what it does.
_Command = Callable[[str, str, str], argparse.ArgumentParser]
# Where the commands live.
_SCENES, _LISTING, _CHECKS = "shockwave.cli.scenes", "shockwave.cli.listing", "shockwave.cli.checks"


def parser() -> argparse.ArgumentParser:
    """The parser of all commands; each sets ``command`` to the place of the function that runs it."""
    made = argparse.ArgumentParser(
        prog="shockwave", description="Solitary waves in granular chains under shocks.", epilog=_EXITS
    )
    made.add_argument("--version", action="version", version=f"shockwave {__version__}")
    made.add_argument("--no-plugins", action="store_true", help=_NO_PLUGINS)
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND")

    def command(name: str, run: str, summary: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=summary, description=summary, epilog=_EXITS)
        added.add_argument("--no-plugins", action="store_true", default=argparse.SUPPRESS, help=_NO_PLUGINS)
        added.set_defaults(command=run)
        return added

    _add_scenes(command)
    _add_checks(command)
    _add_listing(command)
    return made


def _add_scenes(command: _Command) -> None:
    for name, summary in (
        ("predict", "say a priori which waves a shock makes"),
        ("simulate", "integrate the equations of motion and measure the waves"),
        ("compare", "prediction beside simulation"),
        ("validate", "check scenario files and tell every fault"),
    ):
        added = command(name, f"{_SCENES}:{name}", summary)
        added.add_argument("files", nargs="+", metavar="FILE", help="scenario file (YAML)")
        added.add_argument("--json", action="store_true", help="one JSON document on stdout")
        if name in ("simulate", "compare"):
            _add_simulate_options(added)
    report = command("report", f"{_SCENES}:report", "write one page on a scenario, with pictures")
    report.add_argument("file", metavar="FILE", help="scenario file (YAML)")
    report.add_argument("-o", "--output", metavar="FILE", help="write to FILE, not to stdout")
    curve = command(
        "curve", f"{_SCENES}:curve", "the primary's amplification against rise time, for a scenario's shape"
    )
    curve.add_argument("file", metavar="FILE", help="scenario file (YAML)")
    curve.add_argument(
        "--rtol", type=_between(1e-8, 0.1), default=1e-4, help="relative error asked for (default: 1e-4)"
    )
    curve.add_argument(
        "--longest", type=_between(1e-3, 1000), default=50.0, help="longest duration, in natural times (default: 50)"
    )
    curve.add_argument("-o", "--output", metavar="FILE", help="write it (.json), or a picture (.svg, .png, .pdf)")


def _add_checks(command: _Command) -> None:
    bench = command("bench", f"{_CHECKS}:bench", "error against run time: quadratures, predictors, integrators")
    bench.add_argument("files", nargs="*", metavar="FILE", help="scenario files, in place of the named problems")
    bench.add_argument(
        "--family", action="append", default=[], choices=("quadratures", "predictors", "integrators"), help="only these"
    )
    bench.add_argument("--quick", action="store_true", help="fewer problems and settings; ends within a minute")
    bench.add_argument("--longest", type=_between(1e-6, 3600), metavar="SECONDS", help="longest time of one run")
    bench.add_argument("-o", "--output", metavar="FILE", help="write a page (.html), or its figures alone (.svg)")
    stress = command("stress", f"{_CHECKS}:stress", "run the catalogue of extreme cases")
    stress.add_argument("names", nargs="*", metavar="NAME", help="cases or themes; left out, all")
    stress.add_argument("--backend", choices=("auto", "compiled", "numpy"), help="only this one; left out, both")
    for added in (bench, stress):
        added.add_argument("--json", action="store_true", help="one JSON document on stdout")


def _between(low: float, high: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be a number >= {low:g} and <= {high:g} (got {text!r})")
        return value

    return parse


def _add_listing(command: _Command) -> None:
    listing = command("list", f"{_LISTING}:listed", "what is registered, built in and plugged in")
    listing.add_argument("kind", nargs="?", choices=KINDS, help="only these")
    listing.add_argument("--json", action="store_true", help="one JSON document on stdout")
    listing.add_argument(
        "--check", action="store_true", help="import everything that plugins register, and tell faults"
    )
    new = command("new", f"{_LISTING}:new", "write a scenario with every key and its meaning")
    new.add_argument("--profile", default="power-law", help="name of a profile (default: power-law)")
    schema = command(
        "schema", f"{_LISTING}:schema", "write a JSON Schema of scenarios, with what is installed, for editors"
    )
    for added, kept in ((new, "which must not exist, "), (schema, "")):
        added.add_argument("-o", "--output", metavar="FILE", help=f"write to FILE, {kept}not to stdout")


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
