"""The distribution: its name, its declared dependencies, what the sdist holds and how wheels are tagged."""

import ast
import inspect
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

import shockwave as sw
from shockwave import hooks
from shockwave.base.result_tables import library
from shockwave.engine import backend
from support.command_line import shockwave
from support.pages import ROOT, code_in, table

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


def read(name: str) -> str:
    """The text of a file of the source tree."""
    return (ROOT / name).read_text(encoding="utf-8")


@cache
def texts() -> dict[str, str]:
    """The tracked texts but for those of the tests, by name."""
    names = (name for name in tree() if not name.endswith((".png", ".woff2")) and not name.startswith("tests/"))
    return {name: read(name) for name in names}


def project(folder: Path = ROOT) -> dict[str, Any]:
    """The metadata of a distribution of the source tree."""
    found: dict[str, Any] = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


BUILD = tomllib.loads(read("pyproject.toml"))["build-system"]["requires"]


def requirements(*extras: str, folder: Path = ROOT) -> dict[str, str]:
    """Name -> versions of what a distribution needs, with these extras and those that they include."""
    about = project(folder)
    needs = {need.name: str(need.specifier) for need in map(Requirement, about["dependencies"])}
    for need in [Requirement(line) for extra in extras for line in about["optional-dependencies"][extra]]:
        needs |= requirements(*need.extras) if need.name == about["name"] else {need.name: str(need.specifier)}
    return needs


EXTRAS = list(project()["optional-dependencies"])


def test_nothing_names_the_distribution_of_another_project() -> None:
    assert FOREIGN.search("pip install shockwave\n")
    assert not FOREIGN.search("pip install granular-shockwave ./plugins/shockwave-blast\n")
    named = {name: found[0] for name, text in texts().items() if (found := FOREIGN.search(text))}
    assert named == {}


RECIPE = yaml.safe_load(read("conda/recipe.yaml"))


def test_name_version_and_addresses_are_the_same_everywhere() -> None:
    about, citation, recipe = project(), yaml.safe_load(read("CITATION.cff")), RECIPE["about"]
    assert about["name"] == citation["title"] == RECIPE["package"]["name"] == sw.OWN_DISTRIBUTION
    assert about["version"] == citation["version"] == RECIPE["context"]["version"] == sw.__version__
    assert about["urls"]["Repository"] == citation["repository-code"] == recipe["repository"]
    assert about["urls"]["Documentation"] == citation["url"] == recipe["documentation"]
    assert about["description"] == recipe["summary"]
    named = {
        address
        for text in texts().values()
        for address in re.findall(r"https?://[^\s\"')>\]]*granular.shockwave[^\s\"')>\]]*", text)
    }
    known = (*about["urls"].values(), "https://pypi.org/", "https://img.shields.io/", "https://app.readthedocs.org/")
    assert [address for address in named if not address.startswith(known)] == []


def test_the_citation_and_the_paper_have_the_same_reference() -> None:
    (reference,) = yaml.safe_load(read("CITATION.cff"))["references"]
    authors = " and ".join(f"{author['family-names']}, {author['given-names']}" for author in reference["authors"])
    entry = read("paper.bib").partition("\n}\n")[0]
    assert entry.startswith(f"@{reference['type']}{{")
    assert f"author = {{{authors}}},\n  title = {{{reference['title']}}}" in entry


def test_the_recipe_needs_what_the_distribution_needs() -> None:
    needs = RECIPE["requirements"]
    listed = {
        name.removesuffix("-base"): versions
        for name, _, versions in (line.partition(" ") for line in (*needs["run"], *needs["run_constraints"]))
    }
    assert listed == {"python": "", **requirements("plot", "tables")}
    assert [line for line in needs["host"] if line.startswith("setuptools")] == [
        need.replace(">", " >") for need in BUILD
    ]


def test_the_recipe_tests_the_compiled_code() -> None:
    (commands,) = (test["script"] for test in RECIPE["tests"] if "script" in test)
    command = "shockwave simulate - --backend compiled"
    assert [each for each in commands if isinstance(each, dict) and command in each["then"]]
    answer = shockwave(*command.split()[1:], stdin=shockwave("new").out)
    assert (answer.status == 0) == (backend.compiled is not None)


def test_the_readme_is_short() -> None:
    assert len(read("README.md").split()) <= 500


@pytest.mark.parametrize("extra", EXTRAS)
def test_every_dependency_has_a_lowest_version(extra: str) -> None:
    """The environment of lowest versions is made from them."""
    assert [name for name, versions in requirements(extra).items() if not versions.startswith(">=")] == []


def test_the_page_lists_every_extra() -> None:
    assert {code_in(row[0])[0] for row in table("docs/installation.md", "extras")} == set(EXTRAS)


#: Extra -> the code that it serves; that of the package alone is all other code of shockwave.
SERVED = {
    "plot": ["shockwave/pictures/*.py", "docs/gallery/*.py"],
    "notebook": ["docs/notebooks/*.ipynb"],
    "docs": ["shockwave/testing/*.py", "docs/conf.py", "docs/gallery/*.py", "docs/notebooks/*.ipynb"],
    "test": ["tests/**/*.py"],
}
FILES = {extra: [file for pattern in patterns for file in ROOT.glob(pattern)] for extra, patterns in SERVED.items()}
FILES["package"] = sorted({*ROOT.glob("shockwave/**/*.py")}.difference(*FILES.values()))
HOMES = cache(packages_distributions)
#: Modules that are installed from nowhere.
LOCAL = {"granular-shockwave", "shockwave", *(canonicalize_name(path.stem) for path in (ROOT / "tests").rglob("*"))}


def imported(file: Path) -> set[str]:
    """Distributions that a file of Python, a notebook or conf.py imports at run time, late imports included."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".ipynb":
        cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
        text = "\n".join("".join(cell["source"]) for cell in cells)
    tree = ast.parse(text)
    typing = [node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    nodes = {*ast.walk(tree)}.difference(*map(ast.walk, typing))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom) and not node.level}
    if file.name == "conf.py":
        (listed,) = re.findall(r"^extensions = \[(.*?)\]", text, re.MULTILINE | re.DOTALL)
        names |= {*re.findall(r'"(.*?)"', listed), *re.findall(r'^html_theme = "(.*)"', text, re.MULTILINE)}
    modules = {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names)
    return {canonicalize_name(HOMES().get(module, [module])[0]) for module in modules}


@pytest.mark.parametrize("extra", FILES)
def test_each_extra_alone_has_what_its_code_imports(extra: str) -> None:
    assert len(FILES[extra]) > 1
    needed = set().union(*map(imported, FILES[extra])) - LOCAL
    assert needed - requirements(*[] if extra == "package" else [extra]).keys() == set()


def test_errors_on_missing_packages_name_an_extra_that_installs_them() -> None:
    """``library`` imports them by name."""
    code = "".join(file.read_text(encoding="utf-8") for file in sorted((ROOT / "shockwave").rglob("*.py")))
    named = re.findall(r'library\("(\w+)"(?:, "(\w+)")?\)', code)
    default = inspect.signature(library).parameters["extra"].default
    assert {name for name, _ in named} == {"matplotlib", "pandas", "xarray"}
    assert [name for name, extra in named if name not in requirements(extra or default)] == []


RELEASED = "will be the first release" not in read("CHANGELOG.md")


def test_installation_commands_work_before_and_after_a_release() -> None:
    """A path in the source tree, or an extra by name, which adds it to what is installed; on every system."""
    pages = [
        text for name, text in texts().items() if name.endswith((".md", ".py")) and not name.startswith("research/")
    ]
    for before, command in [found for text in pages for found in re.findall(r"(.*)pip install ([^\n`)&]*)", text)]:
        assert before.endswith("python -m "), command
        assert not re.search(r"(^|\s)'", command)  # cmd.exe passes it on
        for place, extras in re.findall(r"(granular-shockwave|\.(?:/[\w-]+)*)(?:\[([\w,]+)\])?(?=[\s\"]|$)", command):
            if place.startswith("./my-"):  # written on its page
                continue
            assert extras or place != sw.OWN_DISTRIBUTION or RELEASED or "Install the release" in before
            folder = ROOT / place if place.startswith(".") else ROOT
            assert {*extras.split(",")} - {""} <= {*project(folder).get("optional-dependencies", {})}


@pytest.mark.parametrize("module", [sw, hooks], ids=lambda module: module.__name__)
def test_type_checkers_and_python_have_the_same_public_names(module: Any) -> None:
    stub = Path(module.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    imports = re.findall(r"^ *from (\S+) import (\w+) as (\w+)$", stub, re.MULTILINE)
    modules = dict.fromkeys(getattr(module, "_MODULES", ()), "shockwave")
    assert {name: home for home, name, _ in imports} == module._HOMES | modules
    assert [name for _, name, exported in imports if name != exported] == []
    assert [name for name in dir(module) if getattr(module, name, None) is None] == []


def workflow(name: str) -> dict[str, Any]:
    """The jobs of a workflow of the public forge."""
    jobs: dict[str, Any] = yaml.safe_load(read(f".github/workflows/{name}.yml"))["jobs"]
    return jobs


def test_the_public_checks_cover_every_system_and_python_version_of_the_classifiers() -> None:
    matrix = workflow("ci")["tests"]["strategy"]["matrix"]
    classifiers = project()["classifiers"]
    versions = [name.rpartition(" ")[2] for name in classifiers if re.fullmatch(r".*:: 3\.\d+", name)]
    assert matrix["python-version"] == versions
    assert len([name for name in classifiers if name.startswith("Operating System")]) == len(matrix["os"])
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}


def test_the_public_checks_run_every_stage() -> None:
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (stages,) = re.findall(r"\$\{\*:-(.*?)\}", run)
    jobs = workflow("ci")
    called = [step["run"] for step in jobs["slow"]["steps"] if "run" in step]
    assert {*jobs["stages"]["strategy"]["matrix"]["stage"], *(one.split()[-1] for one in called)} == {*stages.split()}


def test_only_a_tag_is_published_after_all_builds_by_a_trusted_publisher() -> None:
    jobs = workflow("publish")
    upload = jobs.pop("upload")
    assert upload["if"] == "github.ref_type == 'tag'"
    assert {*upload["needs"]} == {*jobs}
    assert upload["permissions"] == {"id-token": "write"}
    assert [job for job in jobs.values() if "permissions" in job or "secrets" in str(job)] == []
    actions = [step["uses"] for job in (upload, *jobs.values()) for step in job["steps"] if "uses" in step]
    assert [action for action in actions if not re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", action)] == []


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
    own = requirements("test")
    needed = requirements("test", folder=folder)
    versions = SpecifierSet(needed.pop(sw.OWN_DISTRIBUTION))
    assert versions.contains(about["version"], prereleases=True)
    assert not versions.contains("0.1")  # which lacks names that they import
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
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(folder), *BUILD]
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


@pytest.mark.slow
def test_links_of_the_page_on_a_package_index_are_those_of_the_readme_made_absolute(
    source: Path, setuptools: Path
) -> None:
    with tarfile.open(build(source, setuptools, "sdist")) as archive:
        (member,) = (member for member in archive if re.fullmatch("[^/]*/PKG-INFO", member.name))
        text = archive.extractfile(member).read().decode()  # type: ignore[union-attr]
    about, link = project(), r"\]\(([^)]*)\)"
    place = rf"{about['urls']['Repository']}/(?:raw|blob)/v{about['version']}/"
    shown = [re.sub(place, "", target) for target in re.findall(link, text.partition("\n\n")[2])]
    assert [target for target in re.findall(link, text) if "://" not in target] == []
    assert shown == re.findall(link, read("README.md"))


@pytest.mark.slow
@pytest.mark.parametrize("job", ["sdist", "wheels"])
def test_steps_of_a_release_run_here_up_to_the_upload(job: str, source: Path, tmp_path: Path) -> None:
    """Wheels are not built, which takes hours: cibuildwheel lists those that it would build."""
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    path = f"{tmp_path / 'venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "GITHUB_REF_NAME": f"v{project()['version']}"}
    for step in workflow("publish")[job]["steps"]:
        if (command := step.get("run", "")) and not (job == "wheels" and command.startswith("twine")):
            command = command.replace("--output-dir dist", "--print-build-identifiers")
            done = subprocess.run(["bash", "-ec", command], cwd=source, env=environment, text=True, capture_output=True)
            assert done.returncode == 0, f"$ {command}\n{done.stdout}{done.stderr}"
