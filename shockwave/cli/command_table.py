"""The commands and their options, as one table."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from attrs import frozen

from shockwave.cli.option import Change, Option, check_folder, key_option, number_between, one_of, option

#: Page of the documentation on all commands.
PAGE = "https://granular-shockwave.readthedocs.io/en/latest/commands.html"
EXITS = """\
exit status: 0 success; 1 a run failed; 2 wrong usage; 3 invalid scenario;
  4 faulty plugin; 5 file access"""
KINDS = ("profiles", "integrators", "backends", "quadratures", "materials", "contacts", "plugins")

_MANY: dict[str, Any] = {"action": "append", "default": []}

NO_PLUGINS = option("--no-plugins", "use built-in parts only", default=argparse.SUPPRESS)
_WIDE = option("--wide", "show all columns of tables")
_JSON = option("--json", "print one JSON document on stdout")
_FILE = option("FILE", "scenario file (YAML), or - for standard input")
_SET = option("--set PATH=VALUE", "replace a value of the scenario; PATH= deletes it; may be repeated", action=Change)
_SCENARIO = [_FILE, _SET]
_SCENARIOS = [Option(("files",), _FILE.meaning, {"nargs": "+", "metavar": "FILE"}), _SET]
_FORCE_RTOL = option("--rtol RTOL", "relative tolerance of a peak force", type=number_between(1e-7, 1e-2), default=1e-4)
_LIMIT = key_option("--limit FORCE", "limit.force", "limit on the transmitted force, such as '60 N'")
_SIMULATE = [
    key_option("--rtol RTOL", "simulate.rtol"),
    key_option("--step STEP", "simulate.step"),
    key_option("--integrator INTEGRATOR", "simulate.integrator", without=("simulate.rtol", "simulate.step")),
    key_option("--backend BACKEND", "simulate.backend"),
    key_option("--contacts N,N", "simulate.contacts", form="[{}]"),
    key_option("--primary", "simulate.waves", "measure the leading wave only, not all waves", form="primary", nargs=0),
    key_option("--timeout SECONDS", "simulate.timeout"),
]
_DETAIL = [
    option("--explain", "show the decision of section 4 with its symbols, or the simulated waves"),
    option("--verbose", "show everything"),
]
_SIMULATED = [*_SCENARIOS, _JSON, _LIMIT, *_DETAIL, *_SIMULATE]
_RECORD = option(
    "--record FILE", "write the histories (.csv, .nc) or their picture (.svg, .png, .pdf); may be repeated", **_MANY
)
_PREDICTED = [*_SIMULATED, key_option("--model MODEL", "predict.model")]
_VALIDATE = [*_SCENARIOS, _JSON]
_CURVE = [
    *_SCENARIO,
    _FORCE_RTOL,
    option("--longest LONGEST", "longest shock in characteristic times", type=number_between(1e-3, 1e3), default=50.0),
    option("-o --output FILE", "write points (.json) or a picture (.svg, .png, .pdf)"),
]
_SPECTRUM = [
    *_SCENARIO,
    option("--mass MASS", "mass on which the force at the end of the chain acts, unless the end is movable"),
    option("--damping RATIO", "damping ratio of the oscillators (default: 0.05)", default=0.05),
    option("--from FREQUENCY", "lowest natural frequency (default: one period in the simulated time)"),
    option("--to FREQUENCY", "highest natural frequency (default: several periods in a solitary wave)"),
    option("-o --output FILE", "write a table (.csv, .nc) or a picture (.svg, .png, .pdf)"),
    _JSON,
    _DETAIL[-1],
]
_EXPLORE = [
    Option(("file",), f"{_FILE.meaning} (default: an example)", {"nargs": "?", "metavar": "FILE"}),
    _SET,
    option("--port N", "port on loopback, 0 for any free one", type=number_between(0, 65535, int), default=8042),
    option("--no-browser", "print the address of the page without opening it"),
]
_SWEEP = [
    option("FILE", f"{_FILE.meaning}, with a `sweep` block"),
    _SET,
    option("-o --output FOLDER", "folder of the results (default: NAME-sweep for NAME.yaml)", type=check_folder),
    option("--dry-run", "report the number of points and the estimated time; run and write nothing"),
    option("--workers N", "number of workers (default: one for each core)", type=number_between(1, 10_000, int)),
    option(
        "--timeout SECONDS",
        "time limit of a point, which then fails (default: none)",
        type=number_between(1e-3, 1e9),
    ),
    option("--fail-fast", "stop at the first point that fails"),
    option("--retry-failed", "rerun points that failed or crashed"),
    option("--resume", "do not start a new sweep: FOLDER must contain this one"),
    option("--accept-versions", "resume even if the versions of shockwave, a plugin or a dependency have changed"),
    _JSON,
]
_PLOT = [
    option("FOLDER", "folder written by `shockwave sweep`", type=check_folder),
    option("--column NAME", "column or quantity to plot (default: the amplification)"),
    option("--x NAME", "dotted name of the horizontal variable (default: the one with the most values)"),
    option("--at NAME=VALUE", "hold a variable at one of its values; may be repeated", **_MANY),
    option("-o --output FILE", "picture (.svg, .png, .pdf; default: in FOLDER, named after the options)"),
]
_DESIGN = [
    *_SCENARIO,
    option(
        "--vary NAME",
        "dotted name of a number or a material of the chain, the shock or the impact; may be repeated",
        required=True,
        action="append",
    ),
    option(
        "--between A",
        "interval of a number, such as 1mm 20mm: one for each number that varies, in the same order",
        nargs=2,
        **_MANY | {"metavar": ("A", "B")},
    ),
    option("--among NAME,NAME", "materials to compare (default: the whole library)"),
    option(
        "--target REQUIREMENT",
        "quantity, =, <= or >=, and a value, such as 'peak_force = 60 N'; may be repeated",
        required=True,
        action="append",
    ),
    option("--budget REQUIREMENT", "the same, such as 'chain.length <= 0.3 m'; may be repeated", **_MANY),
    option("--least QUANTITY", "quantity to minimise (default: chain.mass)"),
    option("--points N", "number of rows of the table", type=int, default=9),
    _FORCE_RTOL,
    option("--seed N", "seed of the search for several values", type=int, default=0),
    option("-o --output FILE", "write a picture (.svg, .png, .pdf)"),
    _JSON,
]
_UNCERTAINTY = [
    option("FILE", f"{_FILE.meaning}, with an `uncertainty` block"),
    _SET,
    _LIMIT,
    option(
        "--draws N",
        "number of samples, a power of 2 from 256 to 262144 (default: 1024 for equal granules, else 512)",
        type=int,
    ),
    option("--seed N", "seed of the samples; the same seed gives the same digits", type=int, default=0),
    option("--quantity NAME", "further quantity, or a ratio of two; may be repeated", dest="quantities", **_MANY),
    _FORCE_RTOL,
    option("-o --output FILE", "write a picture (.svg, .png, .pdf)"),
    _JSON,
]
_BENCH = [
    option("files", "scenario files to run instead of the named problems", nargs="*", metavar="FILE"),
    _SET,
    option(
        "--family FAMILY",
        "run this family only; may be repeated",
        **_MANY,
        **one_of("quadratures", "predictors", "integrators"),
    ),
    option("--quick", "run fewer problems, settings and repetitions; finishes within a minute"),
    option(
        "--timeout SECONDS",
        "time limit of one run; the table marks longer ones",
        type=number_between(1e-6, 3600),
    ),
    option("-o --output FILE", "write a page (.html)"),
    _JSON,
]
_STRESS = [
    option("names", "cases or themes of the catalogue (default: all)", nargs="*", metavar="NAME"),
    option("--backend BACKEND", "run with this backend only", **one_of("auto", "compiled", "numpy")),
    _JSON,
]
_LIST = [
    option("KIND", "what to list, all of them if omitted", nargs="?", **one_of(*KINDS)),
    option("--check", "import plugins and everything that they register, and report errors"),
    _JSON,
]
_NEW = [
    option("--profile PROFILE", "profile of the shock (default: half-sine; with --full: power-law)"),
    option("--full", "write every key with its meaning"),
    option("--example EXAMPLE", "write an example", **one_of("wall", "striker", "record", "plastic")),
    option("-o --output FILE", "write to FILE, which must not exist (default: stdout)"),
]
_KEYS = [
    option("FILE", "record: a text file with a time and a force column"),
    option("-o --output FILE", "write a scenario with the keys (.yaml) to FILE, which must not exist"),
    option("--picture FILE", "write a picture (.svg, .png, .pdf) of the record and the pulse"),
    _JSON,
]
_SCHEMA = [option("-o --output FILE", "write to FILE (default: stdout)")]
_REPORT = [*_SCENARIO, _LIMIT, option("-o --output FILE", "write to FILE, or to stdout for - (default: NAME.html)")]


# ---------------------------------------------------------------- commands


@frozen
class Command:
    """A command: name, address of its function below `shockwave.cli`, summary, options."""

    name: str
    address: str
    summary: str
    options: list[Option]

    @property
    def all_options(self) -> list[Option]:
        """Its options, and those that every command has."""
        return [*self.options, _WIDE, NO_PLUGINS]

    @property
    def examples(self) -> list[str]:
        """Examples of its use, read from a file."""
        text = Path(__file__).with_name("examples.txt").read_text(encoding="utf-8")
        return re.findall(rf"^(?:.* )?shockwave {self.name}\b[^\\\n]*(?:\\\n.*)?$", text, re.MULTILINE)

    @property
    def epilog(self) -> str:
        """The end of its help: examples, page and exit statuses."""
        examples = "".join(f"  {line}\n" for line in self.examples)
        return f"examples:\n{examples}\n{PAGE}#{self.name}\n\n{EXITS}"


# fmt: off
#: All commands.
COMMANDS = [
    Command("predict", "scenario_commands:predict", "predict the waves that a shock generates", _PREDICTED),
    Command("simulate", "scenario_commands:simulate", "simulate the motion, measure the waves", [*_SIMULATED, _RECORD]),
    Command("compare", "scenario_commands:compare", "compare section 4 with a simulation", _SIMULATED),
    Command("validate", "scenario_commands:validate", "check scenario files and report all errors", _VALIDATE),
    Command("report", "scenario_commands:report", "write a page on a scenario, with pictures", _REPORT),
    Command("explore", "plugin_commands:run", "open a page with sliders in the browser (shockwave-explore)", _EXPLORE),
    Command("spectrum", "spectrum_command:spectrum", "shock response spectrum behind the chain", _SPECTRUM),
    Command("curve", "curve_command:curve", "amplification as a function of the rise time", _CURVE),
    Command("sweep", "sweep_command:sweep", "run or resume all cases of a sweep", _SWEEP),
    Command("plot", "plot_command:plot", "plot the results of a sweep as lines or as a map", _PLOT),
    Command("design", "study_commands:design", "find values of parameters that meet a target", _DESIGN),
    Command("uncertainty", "study_commands:uncertainty", "distribution of forces for uncertain values", _UNCERTAINTY),
    Command("bench", "benchmark_commands:bench", "measure the error of each method against its run time", _BENCH),
    Command("stress", "benchmark_commands:stress", "run the catalogue of extreme cases", _STRESS),
    Command("list", "registry_commands:list_registered", "list the available profiles, integrators, ...", _LIST),
    Command("new", "registry_commands:new", "write a scenario to start from", _NEW),
    Command("record", "record_command:record", "propose the keys of a record file", _KEYS),
    Command("schema", "registry_commands:schema", "write a JSON Schema of scenarios for editors", _SCHEMA),
]
# fmt: on

#: Commands in the table that a sample plugin runs -> that plugin.
OFFERED = {"explore": "shockwave-explore"}
