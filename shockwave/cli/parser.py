"""The commands and their options, as one table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from typing import Any

from shockwave import __version__
from shockwave.base.errors import InvalidValueError
from shockwave.base.units import to_si
from shockwave.scene.force_limit import Limit

KINDS = ("profiles", "integrators", "backends", "quadratures", "materials", "contacts", "plugins")
_EXITS = "exit status: 0 success; 1 a run failed; 2 wrong usage; 3 invalid scenario; 4 faulty plugin; 5 file access"

_Option = tuple[list[str], dict[str, Any]]


def _option(usage: str, meaning: str, **settings: Any) -> _Option:
    """Arguments of `argparse.ArgumentParser.add_argument` for a usage such as ``-o --output FILE`` or ``FILE``.

    A usage without a name for a value is a flag.
    """
    *flags, value = usage.split()
    if value.startswith("-"):
        return [*flags, value], {"action": "store_true", "help": meaning, **settings}
    metavar = None if "choices" in settings else value
    return flags or [value.lower()], {"metavar": metavar, "help": meaning, **settings}


def _number(low: float, high: float, kind: Callable[[str], float] = to_si) -> Callable[[str], float]:
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
        raise argparse.ArgumentTypeError(f"must be whole numbers >= 0, such as 10,20 (got {text!r})")
    return contacts


def _coefficient(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def _limit(text: str) -> Limit:
    try:
        return Limit(force=text)
    except InvalidValueError as error:
        raise argparse.ArgumentTypeError(error.faults[0].problem) from None


# ---------------------------------------------------------------- commands and options

_BACKENDS = ("auto", "compiled", "numpy")
_FAMILIES = ("quadratures", "predictors", "integrators")
_MANY = {"action": "append", "default": []}

_NO_PLUGINS = _option("--no-plugins", "use built-in parts only", default=argparse.SUPPRESS)
_JSON = _option("--json", "print one JSON document on stdout")
_WIDE = _option("--wide", "show all columns of tables")
_FILE = _option("FILE", "scenario file (YAML)")
_FILES = (["files"], {"nargs": "+", **_FILE[1]})
_FORCE_RTOL = _option(
    "--rtol RTOL", "relative tolerance of a peak force (default: 1e-4)", type=_number(1e-7, 1e-2), default=1e-4
)
_LIMIT = _option("--limit FORCE", "limit on the transmitted force, such as '60 N'", type=_limit)
#: These override the keys of the scenario's ``simulate`` block.
_SIMULATE = [
    _option("--rtol RTOL", "relative tolerance, for adaptive methods", type=_number(1e-13, 1e-2)),
    _option("--step STEP", "step in characteristic times, for fixed-step methods", type=_number(1e-9, 1)),
    _option("--integrator INTEGRATOR", "integration method; see `shockwave list integrators`"),
    _option("--backend BACKEND", "code that integrates the chain (default: auto)", choices=_BACKENDS),
    _option("--contacts N,N", "report leading wave and greatest force at these contacts", type=_contacts),
    _option("--primary", "measure the leading wave only, not the whole train"),
    _option("--timeout SECONDS", "maximum computing time (default: none; 10 s for predict)", type=_number(1e-3, 1e9)),
]
_DETAIL = [
    _option("--explain", "show the decision of section 4 with its symbols, or the simulated waves"),
    _option("--verbose", "show everything"),
]
_SIMULATED = [_FILES, _JSON, _LIMIT, *_DETAIL, *_SIMULATE]
#: These override the keys of the scenario's ``predict`` block.
_PREDICT = [
    _option("--momentum-coefficient COEFFICIENT", "coefficient of A: exact, paper, or a number", type=_coefficient),
    _option("--alpha ALPHA", "alpha of section 4.1 (constant) or eq. (5c) as printed", choices=("constant", "literal")),
    _option("--equal-tolerance X", "relative difference up to which forces count as equal", type=_number(0, 1)),
    _option("--quadrature QUADRATURE", "quadrature of all integrals; see `shockwave list quadratures`"),
]
_MODEL = _option("--model MODEL", "best (default), or section-4: the paper alone", choices=("best", "section-4"))
_PREDICTED = [_MODEL, *_PREDICT, *_SIMULATED]
_CURVE = [
    _FORCE_RTOL,
    _option(
        "--longest LONGEST",
        "longest shock in characteristic times (default: 50)",
        type=_number(1e-3, 1e3),
        default=50.0,
    ),
    _option("-o --output FILE", "write points (.json) or a picture (.svg, .png, .pdf)"),
]
_SWEEP = [
    _option("FILE", "scenario file (YAML) with a `sweep` block"),
    _option("-o --out FOLDER", "folder of the results (default: NAME-sweep)"),
    _option("--dry-run", "report the points and the estimated time; run nothing"),
    _option("--workers N", "number of workers (default: one for each core)", type=_number(1, 10_000, int)),
    _option("--timeout SECONDS", "time limit of one point (default: none)", type=_number(1e-3, 1e9)),
    _option("--fail-fast", "stop at the first point that fails"),
    _option("--retry-failed", "run points again that failed or crashed before"),
    _option("--resume", "do not start a new sweep: FOLDER must contain this one"),
    _option("--accept-versions", "resume even if versions of the software have changed"),
]
_PLOT = [
    _option("FOLDER", "folder written by `shockwave sweep`"),
    _option("--column NAME", "quantity to plot (default: amplification)"),
    _option("--x NAME", "horizontal axis (default: variable with the most values)"),
    _option("--at NAME=VALUE", "hold a variable at one of its values; may be repeated", **_MANY),
    _option("-o --output FILE", "picture (.svg, .png, .pdf; default: in FOLDER)"),
]
_DESIGN = [
    _FILE,
    _FORCE_RTOL,
    _JSON,
    _option("--vary NAME", "dotted name of a value to vary; may be repeated", required=True, action="append"),
    _option("--between A", "interval of a number, such as 1mm 20mm", nargs=2, metavar=("A", "B"), **_MANY),
    _option("--among NAME,NAME", "materials to compare (default: the whole library)"),
    _option(
        "--target REQUIREMENT", "requirement, such as 'peak_force = 60 N'; may be repeated", required=True, **_MANY
    ),
    _option("--budget REQUIREMENT", "requirement such as 'chain.length <= 0.3 m'; may be repeated", **_MANY),
    _option("--least QUANTITY", "quantity to minimise (default: chain.mass)"),
    _option("--points N", "number of rows of the table (default: 9)", type=int, default=9),
    _option("--seed N", "seed of the search for several values (default: 0)", type=int, default=0),
    _option("-o --output FILE", "write a picture (.svg, .png, .pdf)"),
]
_UNCERTAINTY = [
    _FORCE_RTOL,
    _JSON,
    _LIMIT,
    _option("FILE", "scenario file (YAML) with an `uncertainty` block"),
    _option("--draws N", "number of samples, a power of 2 (default: 1024 for equal granules, else 512)", type=int),
    _option("--seed N", "seed of the samples (default: 0)", type=int, default=0),
]
_BENCH = [
    _option("files", "scenario files to run instead of the named problems", nargs="*", metavar="FILE"),
    _option("--family FAMILY", "run this family only; may be repeated", choices=_FAMILIES, **_MANY),
    _option("--quick", "run fewer problems and settings (under a minute)"),
    _option("--longest SECONDS", "time limit of one run", type=_number(1e-6, 3600)),
    _option("-o --output FILE", "write a page (.html)"),
]
_STRESS = [
    _option("names", "cases or themes to run (default: all)", nargs="*", metavar="NAME"),
    _option("--backend BACKEND", "run with this backend only (default: both)", choices=_BACKENDS),
]
_LIST = [
    _option("KIND", f"{', '.join(KINDS)} (default: all)", nargs="?", choices=KINDS, metavar="KIND"),
    _option("--check", "import everything that plugins register, report errors"),
]
_NEW = [
    _option("--profile PROFILE", "profile of the shock (default: half-sine; with --full: power-law)"),
    _option("--full", "write every key with its meaning"),
    _option("--example EXAMPLE", "write an example: wall, striker or record", choices=("wall", "striker", "record")),
    _option("-o --output FILE", "write to FILE, which must not exist (default: stdout)"),
]
_OUTPUT = _option("-o --output FILE", "write to FILE (default: stdout)")

#: Commands that print no tables.
_WITHOUT_TABLES = ("validate", "report", "explore", "plot", "new", "schema")

# fmt: off
#: Name, address of the function below `shockwave.cli`, summary, options.
COMMANDS: list[tuple[str, str, str, list[_Option]]] = [
    ("predict", "scenario_commands:predict", "predict the waves that a shock generates", _PREDICTED),
    ("simulate", "scenario_commands:simulate", "simulate the motion, measure the waves", _SIMULATED),
    ("compare", "scenario_commands:compare", "compare section 4 with a simulation", [*_PREDICT, *_SIMULATED]),
    ("validate", "scenario_commands:validate", "check scenario files and report all errors", [_FILES, _JSON]),
    ("report", "scenario_commands:report", "write a page on a scenario, with pictures", [_FILE, _LIMIT, _OUTPUT]),
    ("explore", "plugin_commands:run", "open a page with sliders in the browser (shockwave-explore)", []),
    ("curve", "curve_command:curve", "amplification as a function of the rise time", [_FILE, *_CURVE]),
    ("sweep", "sweep_command:sweep", "run or resume all cases of a sweep", [*_SWEEP, _JSON]),
    ("plot", "plot_command:plot", "plot the results of a sweep as lines or as a map", _PLOT),
    ("design", "design_commands:design", "find values that give a wave or a force a target value", _DESIGN),
    ("uncertainty", "design_commands:uncertainty", "distribution of the forces for uncertain values", _UNCERTAINTY),
    ("bench", "benchmark_commands:bench", "measure the error of each method against its run time", [*_BENCH, _JSON]),
    ("stress", "benchmark_commands:stress", "run the catalogue of extreme cases", [*_STRESS, _JSON]),
    ("list", "registry_commands:list_registered", "list the available profiles, integrators, ...", [*_LIST, _JSON]),
    ("new", "registry_commands:new", "write a scenario to start from", _NEW),
    ("schema", "registry_commands:schema", "write a JSON Schema of scenarios for editors", [_OUTPUT]),
]
# fmt: on

#: Commands in the table that a sample plugin runs -> that plugin.
OFFERED = {"explore": "shockwave-explore"}


class _Version(argparse.Action):
    """Print the version and the back end, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from shockwave.engine.backend import lack

        backend = f"numpy; compiled code {lack()}" if lack() else "compiled"
        print(f"shockwave {__version__} (back end: {backend})")
        parser.exit()


def parser(arguments: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Parser of the command that comes first in ``arguments``; of all commands if none does.

    Each sets ``command`` to the address of the function that runs it.
    """
    made = argparse.ArgumentParser(
        prog="shockwave", description="Solitary waves in granular chains under shocks.", epilog=_EXITS
    )
    made.add_argument("--version", action=_Version, nargs=0, help="print the version and the back end, and exit")
    made.add_argument("--no-plugins", **{**_NO_PLUGINS[1], "default": False})
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, address, summary, options in [row for row in COMMANDS if row[0] in arguments[:1]] or COMMANDS:
        command = commands.add_parser(name, help=summary, description=summary, epilog=_EXITS)
        command.set_defaults(command=address)
        common = [_NO_PLUGINS] if name in _WITHOUT_TABLES else [_NO_PLUGINS, _WIDE]
        for flags, settings in [*common, *options]:
            command.add_argument(*flags, **settings)
    return made


def parsed(arguments: list[str]) -> argparse.Namespace:
    """Options of a command; the arguments of a command of a plugin are left to its function.

    An unknown name is that of a plugin, which is looked up when the command runs.
    """
    own = {name for name, *_ in COMMANDS} - OFFERED.keys()
    no_plugins = arguments[:1] == ["--no-plugins"]
    name, *rest = arguments[no_plugins:] or ["-"]
    if name in own or name.startswith("-"):
        return parser(arguments).parse_args(arguments)
    return argparse.Namespace(command="plugin_commands:run", no_plugins=no_plugins, name=name, arguments=rest)
