"""The commands and their options, as one table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any

from shockwave import __version__

KINDS = ("profiles", "integrators", "backends", "quadratures", "materials", "models", "plugins")
_EXITS = "exit status: 0 done; 1 a run failed; 2 usage; 3 invalid scenario; 4 faulty plugin; 5 file access"

_Option = tuple[list[str], dict[str, Any]]


def _option(usage: str, meaning: str, **settings: Any) -> _Option:
    """Arguments of `argparse.ArgumentParser.add_argument` for a usage such as ``-o --output FILE`` or ``FILE``.

    An option without a name for its value is a flag.
    """
    *flags, value = usage.split()
    if value.startswith("-"):
        return [*flags, value], {"action": "store_true", "help": meaning, **settings}
    metavar = None if "choices" in settings else value
    return flags or [value.lower()], {"metavar": metavar, "help": meaning, **settings}


def _number(low: float, high: float, kind: Callable[[str], float] = float) -> Callable[[str], float]:
    """Parser of a number within limits."""

    def number(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be >= {low:g} and <= {high:g} (got {text})")
        return value

    return number


def _contacts(text: str) -> tuple[int, ...]:
    try:
        contacts = tuple(int(part) for part in text.split(","))
    except ValueError:
        contacts = (-1,)
    if min(contacts) < 0:
        raise argparse.ArgumentTypeError(f"must be whole numbers from 0 on, such as 10,20 (got {text!r})")
    return contacts


# ---------------------------------------------------------------- the table

_BACKENDS = ("auto", "compiled", "numpy")
_FAMILIES = ("quadratures", "predictors", "integrators")
_MANY = {"action": "append", "default": []}

_NO_PLUGINS = _option("--no-plugins", "use nothing but what is built in", default=argparse.SUPPRESS)
_JSON = _option("--json", "one JSON document on stdout")
_WIDE = _option("--wide", "all columns of tables, however wide the screen")
_FILE = _option("FILE", "scenario file (YAML)")
_FILES = (["files"], {"nargs": "+", **_FILE[1]})
_FORCE_RTOL = _option(
    "--rtol RTOL", "relative error allowed of one force (1e-4)", type=_number(1e-7, 1e-2), default=1e-4
)
#: In place of the keys of the scenario's block ``simulate``.
_SIMULATE = [
    _option("--rtol RTOL", "relative error asked for", type=_number(1e-13, 1e-2)),
    _option("--step STEP", "step of a method of fixed step, in characteristic times", type=_number(1e-9, 1)),
    _option("--integrator INTEGRATOR", "name of a method; see `shockwave list integrators`"),
    _option("--backend BACKEND", "which code steps the chain", choices=_BACKENDS),
    _option("--contacts N,N", "contacts whose passage is reported", type=_contacts),
    _option("--primary", "the primary alone, not the whole train"),
    _option("--timeout SECONDS", "longest computing time; left out, none", type=_number(1e-3, 1e9)),
]
_CURVE = [
    _FORCE_RTOL,
    _option("--longest LONGEST", "in characteristic times (default: 50)", type=_number(1e-3, 1e3), default=50.0),
    _option("-o --output FILE", "write it (.json), or a picture (.svg, .png, .pdf)"),
]
_SWEEP = [
    _option("FILE", "scenario file (YAML) with a block sweep"),
    _option("-o --out FOLDER", "journal and results; left out, NAME-sweep for NAME.yaml"),
    _option("--dry-run", "report how many points, what is left out, and how long"),
    _option("--executor NAME", "processes (default), dask, or dask=ADDRESS"),
    _option("--workers N", "how many; left out, one for each core", type=_number(1, 10_000, int)),
    _option("--timeout SECONDS", "longest time of one point; left out, none", type=_number(1e-3, 1e9)),
    _option("--fail-fast", "stop at the first point that fails"),
    _option("--retry-failed", "run points again that failed or crashed before"),
    _option("--resume", "refuse to begin: FOLDER must have this sweep already"),
    _option("--accept-versions", "continue though versions are others than before"),
]
_PLOT = [
    _option("FOLDER", "a folder that the command sweep has written"),
    _option("--column NAME", "the quantity (default: the amplification)"),
    _option("--x NAME", "the variable from left to right (default: that of most values)"),
    _option("--at NAME=VALUE", "hold a variable; may be given again", **_MANY),
    _option("-o --output FILE", "a picture (.svg, .png, .pdf); left out, in the folder"),
]
_DESIGN = [
    _FILE,
    _FORCE_RTOL,
    _JSON,
    _option("--vary NAME", "dotted name of the value, or chain.material", required=True),
    _option(
        "--target QUANTITY=VALUE", "the target property, such as peak_force='60 N'", required=True, action="append"
    ),
    _option("--between A", "the interval of a number, such as 1mm 20mm", nargs=2, metavar=("A", "B")),
    _option("--among NAME,NAME", "materials to compare; left out, all of the library"),
    _option("--points N", "rows of the table (default: 9)", type=int, default=9),
    _option("-o --output FILE", "write a picture (.svg, .png, .pdf)"),
]
_UNCERTAINTY = [
    _FORCE_RTOL,
    _JSON,
    _option("FILE", "scenario file (YAML) with a block uncertainty"),
    _option("--draws N", "a power of 2 (default: 4096)", type=int, default=4096),
    _option("--seed N", "the same gives the same digits", type=int, default=0),
]
_BENCH = [
    _option("files", "scenario files, in place of the named problems", nargs="*", metavar="FILE"),
    _option("--family FAMILY", "only these", choices=_FAMILIES, **_MANY),
    _option("--quick", "fewer problems and settings; ends within a minute"),
    _option("--longest SECONDS", "longest time of one run", type=_number(1e-6, 3600)),
    _option("-o --output FILE", "write a page (.html)"),
]
_STRESS = [
    _option("names", "cases or themes; left out, all", nargs="*", metavar="NAME"),
    _option("--backend BACKEND", "only this one; left out, both", choices=_BACKENDS),
]
_LIST = [
    _option("KIND", "only these", nargs="?", choices=KINDS),
    _option("--check", "import everything that plugins register, and report errors"),
]
_NEW = [
    _option("--profile PROFILE", "name of a profile (default: power-law)", default="power-law"),
    _option("-o --output FILE", "write to FILE, which must not exist, not to stdout"),
]
_OUTPUT = _option("-o --output FILE", "write to FILE, not to stdout")

# fmt: off
#: Name, address of the function below `shockwave.cli`, summary, options.
_COMMANDS: list[tuple[str, str, str, list[_Option]]] = [
    ("predict", "scenario_commands:predict", "predict the waves that a shock makes", [_FILES, _JSON]),
    ("simulate", "scenario_commands:simulate", "integrate the motion, measure the waves", [_FILES, _JSON, *_SIMULATE]),
    ("compare", "scenario_commands:compare", "prediction beside simulation", [_FILES, _JSON, *_SIMULATE]),
    ("validate", "scenario_commands:validate", "check scenario files and report all errors", [_FILES, _JSON]),
    ("report", "scenario_commands:report", "write one page on a scenario, with pictures", [_FILE, _OUTPUT]),
    ("curve", "scenario_commands:curve", "amplification against rise time, for a scenario's shape", [_FILE, *_CURVE]),
    ("sweep", "sweep:sweep", "run all scenes that a scenario with a sweep stands for", [*_SWEEP, _JSON]),
    ("plot", "plot:plot", "draw the results of a sweep: lines, or a map", _PLOT),
    ("design", "design:design", "find the values at which the primary has the target property", _DESIGN),
    ("uncertainty", "design:uncertainty", "distribution of the primary where values are uncertain", _UNCERTAINTY),
    ("bench", "benchmark_commands:bench", "error against run time of the methods", [*_BENCH, _JSON]),
    ("stress", "benchmark_commands:stress", "run the catalogue of extreme cases", [*_STRESS, _JSON]),
    ("list", "registry_commands:list_registered", "what is registered, built in and plugged in", [*_LIST, _JSON]),
    ("new", "registry_commands:new", "write a scenario with every key and its meaning", _NEW),
    ("schema", "registry_commands:schema", "write a JSON Schema of scenarios, for editors", [_OUTPUT]),
]
# fmt: on


def parser() -> argparse.ArgumentParser:
    """The parser of all commands; each sets ``command`` to the address of the function that runs it."""
    made = argparse.ArgumentParser(
        prog="shockwave", description="Solitary waves in granular chains under shocks.", epilog=_EXITS
    )
    made.add_argument("--version", action="version", version=f"shockwave {__version__}")
    made.add_argument("--no-plugins", **{**_NO_PLUGINS[1], "default": False})
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, address, summary, options in _COMMANDS:
        command = commands.add_parser(name, help=summary, description=summary, epilog=_EXITS)
        command.set_defaults(command=address)
        for flags, settings in [_NO_PLUGINS, _WIDE, *options]:
            command.add_argument(*flags, **settings)
    return made
