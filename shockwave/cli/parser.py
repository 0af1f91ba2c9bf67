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
    _add_sweep(command)
    _add_plot(command)
    _add_design(command)
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
        "--rtol", type=_between(1e-7, 1e-2), default=1e-4, help="relative error asked for (default: 1e-4)"
    )
    curve.add_argument(
        "--longest", type=_between(1e-3, 1000), default=50.0, help="longest duration, in natural times (default: 50)"
    )
    curve.add_argument("-o", "--output", metavar="FILE", help="write it (.json), or a picture (.svg, .png, .pdf)")


def _add_plot(command: _Command) -> None:
    plot = command("plot", "shockwave.cli.plot:plot", "draw the results of a sweep: lines, or a map")
    plot.add_argument("folder", metavar="FOLDER", help="a folder that the command sweep has written")
    plot.add_argument("--column", metavar="NAME", help="the quantity (default: the amplification)")
    plot.add_argument("--x", metavar="NAME", help="the variable from left to right (default: that of most values)")
    plot.add_argument(
        "--at", action="append", default=[], metavar="NAME=VALUE", help="hold a variable; may be given again"
    )
    plot.add_argument("-o", "--output", metavar="FILE", help="a picture (.svg, .png, .pdf); left out, in the folder")


def _add_design(command: _Command) -> None:
    place, files = "shockwave.cli.design", "scenario file (YAML)"
    design = command("design", f"{place}:design", "find the values at which the primary is as wanted")
    design.add_argument("file", metavar="FILE", help=files)
    design.add_argument("--vary", required=True, metavar="NAME", help="dotted name of the value, or chain.material")
    design.add_argument(
        "--target",
        required=True,
        action="append",
        metavar="QUANTITY=VALUE",
        help="what is wanted, such as peak_force='60 N'",
    )
    design.add_argument("--between", nargs=2, metavar=("A", "B"), help="the interval of a number, such as 1mm 20mm")
    design.add_argument("--among", metavar="NAME,NAME", help="materials to compare; left out, all of the library")
    design.add_argument("--points", type=int, default=9, metavar="N", help="rows of the table (default: 9)")
    design.add_argument("-o", "--output", metavar="FILE", help="write a picture (.svg, .png, .pdf)")
    uncertainty = command(
        "uncertainty", f"{place}:uncertainty", "the primary's distribution where values of a scenario are uncertain"
    )
    uncertainty.add_argument("file", metavar="FILE", help=f"{files} with a block uncertainty")
    uncertainty.add_argument("--draws", type=int, default=4096, metavar="N", help="a power of 2 (default: 4096)")
    uncertainty.add_argument("--seed", type=int, default=0, metavar="N", help="the same gives the same digits")
    for added in (design, uncertainty):
        added.add_argument(
            "--rtol", type=_between(1e-7, 1e-2), default=1e-4, help="relative error allowed of one force (1e-4)"
        )
        added.add_argument("--json", action="store_true", help="one JSON document on stdout")


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


def _add_sweep(command: _Command) -> None:
    sweep = command("sweep", "shockwave.cli.sweep:sweep", "run all scenes that a scenario with a sweep stands for")
    sweep.add_argument("file", metavar="FILE", help="scenario file (YAML) with a block sweep")
    sweep.add_argument("-o", "--out", metavar="FOLDER", help="journal and results; left out, NAME-sweep for NAME.yaml")
    sweep.add_argument("--dry-run", action="store_true", help="tell how many points, what is left out, and how long")
    sweep.add_argument("--executor", metavar="NAME", help="processes (default), dask, or dask=ADDRESS")
    sweep.add_argument("--workers", type=_at_least_one, metavar="N", help="how many; left out, one for each core")
    sweep.add_argument(
        "--timeout", type=_between(1e-3, 1e9), metavar="SECONDS", help="longest time of one point; left out, none"
    )
    sweep.add_argument("--fail-fast", action="store_true", help="stop at the first point that fails")
    sweep.add_argument("--retry-failed", action="store_true", help="run points again that failed or crashed before")
    sweep.add_argument("--resume", action="store_true", help="refuse to begin: FOLDER must have this sweep already")
    sweep.add_argument("--accept-versions", action="store_true", help="go on though versions are others than before")
    sweep.add_argument("--json", action="store_true", help="one JSON document on stdout")


def _at_least_one(text: str) -> int:
    if not text.isdecimal() or not 0 < int(text) <= 10_000:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1 and <= 10000 (got {text!r})")
    return int(text)


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
