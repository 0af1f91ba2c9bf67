"""The structure of the package: imports run downwards, the two columns stay apart, nothing is loaded in vain."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import shockwave

ROOT = Path(__file__).parent.parent
PACKAGE = Path(shockwave.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))

# A module may import from its own room and from those on lower floors.
FLOORS = {
    "errors": 0,
    "hooks": 0,
    "text": 0,
    "built_ins": 1,
    "fields": 1,
    "files": 1,
    "markup": 1,
    "numerics": 1,
    "quadrature": 2,
    "registry": 2,
    "options": 3,
    "profiles": 3,
    "chain": 3,
    "scene": 4,
    "simulation": 4,
    "prediction": 5,
    "measurement": 5,
    "pictures": 6,
    "scenario": 6,
    "studies": 7,
    "page": 8,
    "sweep": 8,
    "testing": 8,
    "benchmark": 9,
    "cli": 10,
    "__main__": 11,
}
A_PRIORI = {"prediction", "scenario"}
DIRECT = {"simulation", "measurement"}


def room(file: Path) -> str:
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imports(file: Path) -> set[str]:
    """Rooms of shockwave that ``file`` imports at run time; what stands under TYPE_CHECKING is for types alone."""
    tree = ast.parse(file.read_text())
    typing_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    modules = [
        name
        for node in ast.walk(tree)
        if id(node) not in typing_only
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [f"{node.module}.{alias.name}" for alias in node.names]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    ]
    return {name.split(".")[1] for name in modules if name.startswith("shockwave.")}


MODULES = [file for file in FILES if file != PACKAGE / "__init__.py"]


def test_imports_run_downwards() -> None:
    own = {"__version__", "OWN_DISTRIBUTION"}
    above = {
        (str(file.relative_to(PACKAGE.parent)), other)
        for file in MODULES
        for other in imports(file) - {room(file)} - own
        if FLOORS[other] >= FLOORS[room(file)]
    }
    assert above == set()


def test_columns_never_import_each_other() -> None:
    others = {**dict.fromkeys(A_PRIORI, DIRECT), **dict.fromkeys(DIRECT, A_PRIORI)}
    wrong = {str(file.relative_to(PACKAGE.parent)): imports(file) & others.get(room(file), set()) for file in MODULES}
    assert {file: rooms for file, rooms in wrong.items() if rooms} == {}


def test_files_are_short_enough_to_read() -> None:
    assert [str(file) for file in FILES if len(file.read_text().splitlines()) > 400] == []


def test_sample_plugins_are_never_imported() -> None:
    example = "shockwave_pulses.half_sine:HalfSine"
    assert [str(file) for file in FILES if "shockwave_pulses." in file.read_text().replace(example, "")] == []


@cache
def loaded(program: str) -> set[str]:
    """Modules in memory after ``program`` has run in an interpreter of its own."""
    run = subprocess.run(
        [sys.executable, "-c", f"{program}\nimport sys; print(*sys.modules, file=sys.stderr)"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return set(run.stderr.split())


SCENE = "profiles/paper/table2-row1.yaml"


def command(*arguments: str) -> str:
    return f"from shockwave.cli import main; assert main({list(arguments)!r}) == 0"


def test_importing_the_package_loads_no_numbers() -> None:
    assert {"numpy", "scipy", "attrs", "pint", "yaml", "pluggy"} & loaded("import shockwave") == set()


def test_help_loads_no_numbers() -> None:
    program = "from shockwave.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    assert {"numpy", "scipy", "pint", "yaml"} & loaded(program) == set()


def test_listing_imports_nothing_that_it_lists() -> None:
    modules = loaded(command("list"))
    assert {"numpy", "scipy", "shockwave.profiles", "shockwave.chain"} & modules == set()
    # whether the compiled code is there cannot be told without a look at it
    simulation = {name for name in modules if name.startswith("shockwave.simulation.")}
    assert simulation <= {"shockwave.simulation.backend", "shockwave.simulation._compiled"}


def test_prediction_loads_no_simulator() -> None:
    modules = loaded(command("predict", SCENE))
    assert {m for m in modules if m.startswith(("shockwave.simulation", "shockwave.measurement"))} == set()


def test_prediction_of_a_closed_form_loads_no_scipy() -> None:
    assert {m for m in loaded(command("predict", SCENE)) if m.split(".")[0] == "scipy"} == set()


def test_prediction_of_a_closed_form_loads_no_quadrature() -> None:
    modules = loaded(command("predict", SCENE))
    assert {m for m in modules if m.startswith("shockwave.quadrature.")} <= {"shockwave.quadrature.base"}


def test_a_scene_loads_its_own_profile_alone() -> None:
    modules = loaded(command("predict", SCENE))
    others = {f"shockwave.profiles.{name}" for name in ("exponential", "triangular", "record")}
    assert others & modules == set()


def test_a_simulation_loads_no_predictor() -> None:
    program = (
        "import shockwave as sw\n"
        "chain = sw.Chain(material=sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)\n"
        "shock = sw.Shock(profile=sw.Triangular(duration_ratio=2), peak_force=1.0, rise_time=1e-6)\n"
        "sw.simulate(shock, chain, rtol=1e-2)"
    )
    modules = loaded(program)
    assert {m for m in modules if m.startswith(("shockwave.prediction", "shockwave.prediction"))} == set()


def test_units_are_loaded_only_for_a_file_that_has_one(tmp_path: Path) -> None:
    bare = tmp_path / "bare.yaml"
    bare.write_text(
        "chain: {material: {youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1000}, radius: 1e-3}\n"
        "shock: {profile: triangular, peak_force: 10, rise_time: 1e-5, duration_ratio: 3}\n"
    )
    assert "pint" not in loaded(command("predict", str(bare)))


def test_built_in_names_scan_no_entry_points() -> None:
    program = (
        "import importlib.metadata as m\n"
        "def refuse(*_, **__): raise AssertionError('scanned')\n"
        "m.entry_points = m.distributions = refuse\n" + command("predict", SCENE)
    )
    loaded(program)


def test_every_public_name_has_a_home() -> None:
    program = "import shockwave\nfor name in shockwave.__all__: getattr(shockwave, name)"
    loaded(program)
