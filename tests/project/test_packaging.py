"""The distribution: its name, its declared dependencies, what the sdist holds and how wheels are tagged."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

import shockwave as sw
from shockwave import hooks
from support.pages import ROOT

#: The distribution of another project, as it would be named in a command, a hint or a requirement.
FOREIGN = re.compile(
    r"""(pip|uv|pipx)\ (install|download)[^\n`&|;]*[ "']shockwave(?![\w-])
      | ["'`\s]shockwave(\[(?!\[)[a-z,]+\]["'`\s] | \s*[<>=~!]=\s*\d)""",
    re.VERBOSE,
)


def tree() -> list[str]:
    """Paths in the source tree that are tracked."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [name for name in listed.split("\n") if (ROOT / name).is_file() and name != ".gitignore"]


if not (ROOT / ".git").exists():
    pytest.skip("the source tree is no clone", allow_module_level=True)

TEXTS = [name for name in tree() if not name.endswith(".png") and not name.startswith("tests/")]


def project(folder: Path = ROOT) -> dict[str, Any]:
    """The metadata of a distribution of the source tree."""
    found: dict[str, Any] = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def floors(requirements: list[str]) -> dict[str, str]:
    """Name -> what is required of it."""
    return {made.name: str(made.specifier) for made in map(Requirement, requirements)}


def test_nothing_names_the_distribution_of_another_project() -> None:
    assert FOREIGN.search("pip install shockwave\n")
    assert not FOREIGN.search("pip install granular-shockwave ./plugins/shockwave-blast\n")
    named = {name: found[0] for name in TEXTS if (found := FOREIGN.search((ROOT / name).read_text(encoding="utf-8")))}
    assert named == {}


def test_name_and_version_are_the_same_everywhere() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    about = project()
    assert about["name"] == citation["title"] == sw.OWN_DISTRIBUTION
    assert about["version"] == citation["version"] == sw.__version__


def test_every_dependency_has_a_floor_and_the_tests_have_those_of_the_extras() -> None:
    """The environment of lowest versions is made from them."""
    extras = {name: floors(needs) for name, needs in project()["optional-dependencies"].items()}
    needed = floors(project()["dependencies"]) | extras["test"]
    assert [name for name, floor in needed.items() if not floor.startswith(">=")] == []
    assert extras["test"].items() >= extras["plot"].items()


@pytest.mark.parametrize("module", [sw, hooks], ids=lambda module: module.__name__)
def test_type_checkers_and_python_have_the_same_public_names(module: Any) -> None:
    stub = Path(module.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    imports = re.findall(r"^ *from (\S+) import (\w+) as (\w+)$", stub, re.MULTILINE)
    modules = dict.fromkeys(getattr(module, "_MODULES", ()), "shockwave")
    assert {name: home for home, name, _ in imports} == module._HOMES | modules
    assert [name for _, name, exported in imports if name != exported] == []
    assert [name for name in dir(module) if getattr(module, name, None) is None] == []


def workflow() -> dict[str, Any]:
    """The jobs of the public forge."""
    document = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
    jobs: dict[str, Any] = document["jobs"]
    return jobs


def test_the_public_checks_cover_every_system_and_python_version_of_the_classifiers() -> None:
    matrix = workflow()["tests"]["strategy"]["matrix"]
    classifiers = project()["classifiers"]
    versions = [name.rpartition(" ")[2] for name in classifiers if re.fullmatch(r".*:: 3\.\d+", name)]
    assert matrix["python-version"] == versions
    assert len([name for name in classifiers if name.startswith("Operating System")]) == len(matrix["os"])
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}


def test_the_public_checks_run_every_stage() -> None:
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (stages,) = re.findall(r"\$\{\*:-(.*?)\}", run)
    jobs = workflow()
    called = [step["run"] for step in jobs["slow"]["steps"] if "run" in step]
    assert {*jobs["stages"]["strategy"]["matrix"]["stage"], *(one.split()[-1] for one in called)} == {*stages.split()}


def test_the_paper_has_what_the_journal_asks_for_and_cites_what_it_lists() -> None:
    _, header, text = (ROOT / "paper.md").read_text(encoding="utf-8").split("---\n", 2)
    about = yaml.safe_load(header)
    assert about.keys() >= {"title", "tags", "authors", "affiliations", "date", "bibliography"}
    headings = re.findall("^# (.*)", text, re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field", "References"} <= {*headings}
    assert 250 <= len(text.split()) <= 1750
    listed = re.findall(r"^@\w+\{(\w+),", (ROOT / about["bibliography"]).read_text(encoding="utf-8"), re.MULTILINE)
    assert {*re.findall(r"@(\w+)", text)} == {*listed}


@pytest.mark.parametrize("folder", sorted((ROOT / "plugins").glob("*/")), ids=lambda folder: folder.name)
def test_sample_plugins_need_the_same_versions_as_shockwave(folder: Path) -> None:
    about = project()
    own = floors([*about["dependencies"], *about["optional-dependencies"]["test"]])
    needed = floors([*project(folder)["dependencies"], *project(folder)["optional-dependencies"]["test"]])
    assert SpecifierSet(needed.pop(sw.OWN_DISTRIBUTION)).contains(about["version"], prereleases=True)
    assert {name: floor for name, floor in needed.items() if name in own}.items() <= own.items()


#: Written over what Python says of itself, before setup.py is run.
FREE_THREADED = """
import sysconfig
variable = sysconfig.get_config_var
sysconfig.get_config_var = lambda name: 1 if name == "Py_GIL_DISABLED" else variable(name)
"""
WINDOWS = "import sysconfig; sysconfig.get_platform = lambda: 'win-amd64'\n"


@pytest.fixture(scope="session")
def setuptools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what builds need, of a version that reads the project file."""
    folder = tmp_path_factory.mktemp("setuptools")
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(folder), *build]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A copy of the source tree."""
    for name in tree():
        copy = tmp_path / "source" / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, copy)
    return tmp_path / "source"


def build(source: Path, setuptools: Path, command: str, before: str = "", **variables: str) -> Path:
    """What a command of setup.py leaves in ``dist``, after the lines ``before``."""
    program = f"{before}\nimport sys, runpy; sys.argv = ['setup.py', '-q', {command!r}]; runpy.run_path('setup.py')"
    environment = {**os.environ, "PYTHONPATH": str(setuptools), **variables}
    done = subprocess.run([sys.executable, "-c", program], cwd=source, env=environment, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    (made,) = (source / "dist").iterdir()
    return made


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "variables"),
    [("", {"CC": "false"}), (FREE_THREADED, {}), (WINDOWS, {})],
    ids=["no compiler", "free-threaded", "Windows"],
)
def test_a_wheel_without_compiled_code_serves_all_platforms(
    before: str, variables: dict[str, str], source: Path, setuptools: Path
) -> None:
    wheel = build(source, setuptools, "bdist_wheel", before, **variables)
    assert wheel.name.endswith("-py3-none-any.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert [name for name in names if name.endswith((".so", ".pyd"))] == []
    assert {"shockwave/__init__.pyi", "shockwave/py.typed"} <= set(names)


@pytest.mark.slow
def test_the_sdist_holds_the_source_tree_and_nothing_else(source: Path, setuptools: Path) -> None:
    (source / "docs" / "_build").mkdir()
    (source / "docs" / "_build" / "index.html").touch()
    with tarfile.open(build(source, setuptools, "sdist")) as archive:
        held = {member.name.partition("/")[2] for member in archive if member.isfile()}
    made = {name for name in held if name.startswith("granular_shockwave.egg-info/")} | {"PKG-INFO", "setup.cfg"}
    assert held - made == set(tree())
