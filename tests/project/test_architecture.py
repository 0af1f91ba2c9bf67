"""The structure of the package: imports run downwards, the two columns stay apart, nothing is loaded in vain."""

import ast
import doctest
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import shockwave
from conftest import NOT_NUMERICAL
from shockwave import hooks, testing
from support.pages import DOCS, blocks_of, code_in, table
from support.programs import SCENE, command, loaded

ROOT = Path(__file__).parents[2]
PACKAGE = Path(shockwave.__file__).parent
FILES = {
    ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): file
    for file in sorted(PACKAGE.rglob("*.py"))
}
# The lazy list of public names is no import of the package by itself.
MODULES = [module for module in FILES if module != "shockwave"]

#: Room -> its floor. A module may import from its own room and from those on lower floors.
FLOORS = {name: -row for row, cells in enumerate(table("CONTRIBUTING.md", "rooms")) for name in code_in(cells[1])}
FLOORS["__main__"] = 1
#: Rooms of the engine, and modules that must not need them.
ENGINE = {"engine", "simulation"}
WITHOUT_ENGINE = ("prediction.section4", "prediction.scaled_shock", "prediction.section4_outcome", "scenario")


def room(module: str) -> str:
    return module.split(".")[1]


@cache
def imports(module: str) -> set[str]:
    """Modules of the package that ``module`` imports, late or for types alone too."""
    names = set()
    for node in ast.walk(ast.parse(FILES[module].read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            # a name of a module may be a module itself
            names |= {f"{node.module}.{alias.name}" for alias in node.names} | {str(node.module)}
    return names & set(MODULES) - {module}


def test_folders_of_tests_that_are_not_numerical_exist() -> None:
    assert {file.name for file in (ROOT / "tests").iterdir()} >= NOT_NUMERICAL


def test_imports_run_downwards() -> None:
    above = {
        (module, other)
        for module in MODULES
        for other in imports(module)
        if room(other) != room(module) and FLOORS[room(other)] >= FLOORS[room(module)]
    }
    assert above == set()


def test_no_files_import_each_other_in_a_cycle() -> None:
    # raises CycleError, which names the modules
    TopologicalSorter({module: imports(module) for module in MODULES}).prepare()


def test_section_4_and_the_engine_never_import_each_other() -> None:
    apart = [module for module in MODULES if module.removeprefix("shockwave.").startswith(WITHOUT_ENGINE)]
    assert {f"shockwave.{name}" for name in WITHOUT_ENGINE} <= set(apart)
    for module in MODULES:
        others = set(map(room, imports(module)))
        assert module not in apart or ENGINE.isdisjoint(others), module
        assert room(module) not in ENGINE or others.isdisjoint({"prediction", "scenario"}), module


def test_only_the_predictor_asks_the_engine() -> None:
    program = "import shockwave.prediction.outcome_text, shockwave.prediction.predictor"
    assert {name for name in loaded(program) if name.startswith(COLUMN)} == set()


def test_rooms_are_few_and_files_short() -> None:
    folders = {file.relative_to(PACKAGE).parts[0] for file in FILES.values() if file.parent != PACKAGE}
    # the files at the top are one room
    assert len(folders) + 1 <= 17
    assert [module for module, file in FILES.items() if len(file.read_text().splitlines()) > 400] == []


IN_PYTHON = """
import shockwave as sw
chain = sw.Chain(material=sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)
shock = sw.Shock(profile=sw.Triangular(duration_ratio=2), peak_force=1.0, rise_time=1e-6)
"""
#: All that is shown of a result.
SHOWN = "; str(result), result.text(), repr(result), result._repr_html_(), result.to_dict(), result.verdict"
HELP = "from shockwave.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass"
COLUMN = "shockwave.engine", "shockwave.simulation"
OUTPUT = "shockwave.benchmark", "shockwave.report", "shockwave.pictures", "matplotlib", "jinja2", "pebble"
SLOW = "scipy", "pint", "cattrs", "pluggy", "importlib.metadata", "concurrent", "numpy.ma.", "secrets", "tempfile"
#: Modules for chains beyond equal spheres.
FEATURES = (
    *(f"shockwave.scene.{name}" for name in ("chain_end", "contact_law", "coverage_rules", "damping", "description")),
    *("shockwave.scene.elastic_plastic", "shockwave.scene.plastic_range", "shockwave.simulation.yield_advice"),
    *(f"shockwave.scene.{name}" for name in ("feature_rules", "impact", "layout", "power_law_wave", "segments")),
    *(f"shockwave.simulation.{name}" for name in ("contact_forces", "contact_setup", "convergence_runs")),
    *(f"shockwave.simulation.{name}" for name in ("shock_spectrum", "transmitted_spectrum")),
    "shockwave.studies.record_keys",
    *("shockwave.scene.sensors", "shockwave.simulation.chain_histories"),
    *("shockwave.simulation.first_pulse", "shockwave.simulation.sampled_history"),
    "shockwave.engine.integrator_steps",
    *(f"shockwave.engine.chain_{name}" for name in ("assembly", "domains", "motion", "plastic")),
    "shockwave.scenario.chain_blocks",
)
#: Modules that integrate whole chains, and those of wave trains.
INTEGRATION = "shockwave.engine._chains", "shockwave.engine.chain_run"
TRAINS = "shockwave.simulation.wave_train", "shockwave.simulation.wave_passages"
TABLES = "shockwave.profiles.quadrature.gauss", "shockwave.profiles.free_path"
OTHER_PROFILES = "shockwave.profiles.exponential", "shockwave.profiles.triangular", "shockwave.records"


def test_the_modules_that_must_not_load_exist() -> None:
    own = (
        *COLUMN,
        *INTEGRATION,
        *FEATURES,
        *OTHER_PROFILES,
        *TABLES,
        *TRAINS,
        *(name for name in OUTPUT if name.startswith("shockwave")),
    )
    compiled = [f"shockwave.engine.{name}" for name in ("_chains", "_lanes")]
    assert [name for name in own if not any(each.startswith(name) for each in [*FILES, *compiled])] == []


@pytest.mark.parametrize(
    ("program", "unwanted"),
    [
        ("import shockwave", ("numpy", "scipy", "attrs", "pint", "yaml", "pluggy")),
        ("from shockwave.hooks import Entry, hookimpl", ("numpy", "scipy", "attrs", "pint", "yaml")),
        (HELP, ("numpy", "scipy", "pint", "yaml")),
        (command("list"), ("numpy", "scipy", "shockwave.profiles", "shockwave.scene.chain")),
        (
            command("predict", "--model", "section-4", SCENE),
            (*COLUMN, *OTHER_PROFILES, *OUTPUT, *SLOW, *FEATURES, *TABLES),
        ),
        (command("simulate", SCENE), (*OUTPUT, *SLOW, *FEATURES)),
        ("import shockwave.pictures", ("matplotlib",)),
        (f"{IN_PYTHON}result = sw.simulate(shock, chain, limit=3.0){SHOWN}", ("shockwave.prediction",)),
        (f"{IN_PYTHON}result = sw.predict(shock, chain, model='section-4', limit=3.0){SHOWN}", (*COLUMN, "scipy")),
        (f"{IN_PYTHON}sw.predict(shock, chain).peak_force", (*OUTPUT, *SLOW, *FEATURES, *INTEGRATION, *TRAINS)),
    ],
    ids=["import", "hooks", "help", "list", "predict", "simulate", "pictures", "simulate-in-python", "paper", "best"],
)
def test_a_program_does_not_load(program: str, unwanted: tuple[str, ...]) -> None:
    assert {name for name in loaded(program) if name.startswith(unwanted)} == set()


#: What authors of plugins import; the explorer, which is made with the package, takes more.
PUBLIC = {"shockwave", "shockwave.pictures"} | {
    f"{module.__name__}.{name}" for module in (shockwave, hooks, testing) for name in module.__all__
}
SAMPLES = sorted(set((ROOT / "plugins").glob("shockwave-*")) - {ROOT / "plugins" / "shockwave-explore"})
TUTORIALS = [DOCS / f"{name}.md" for name in ("write-a-profile", "write-an-integrator", "plugins")]
#: The numbers of a README include those of built-in integrators.
COMPARED = {"shockwave-composition": {"shockwave.registry.registry.load"}}


def sources(place: Path) -> Iterator[str]:
    """The Python code of a folder or a page."""
    yield from (file.read_text(encoding="utf-8") for file in sorted(place.rglob("*.py")))
    for page in [place] if place.is_file() else sorted(place.glob("*.md")):
        for block in blocks_of(page):
            if block.language == "python":
                yield block.text
            elif block.language == "pycon":
                yield from (example.source for example in doctest.DocTestParser().get_examples(block.text))


@pytest.mark.parametrize("place", [*SAMPLES, *TUTORIALS], ids=lambda place: place.stem)
def test_sample_plugins_and_tutorials_import_public_names_alone(place: Path) -> None:
    names = set()
    for node in [node for source in sources(place) for node in ast.walk(ast.parse(source))]:
        if isinstance(node, ast.ImportFrom | ast.Import):
            module = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            names |= {module + alias.name for alias in node.names}
    used = {name for name in names if name.split(".")[0] == "shockwave"}
    assert used
    assert used - PUBLIC == COMPARED.get(place.name, set())
