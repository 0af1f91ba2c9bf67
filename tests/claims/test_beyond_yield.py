"""Shipped examples stay below first yield or include plastic flow; the others are listed with a reason."""

import json
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import yaml

import shockwave as sw
from support import pages
from support.beyond_yield import BEYOND_YIELD, notes_of_sweeps, warnings_of, warns_beyond_yield
from support.pages import DOCS, PAGES, ROOT, Block, blocks_of

FILES = [
    *sorted((ROOT / "profiles").glob("*/*.yaml")),
    *sorted((ROOT / "plugins").glob("*/profiles/*.yaml")),
    *sorted((ROOT / "plugins").glob("*/src/*/scenes/*.yaml")),
]
SWEEPS = [file for file in FILES if "\nsweep:" in file.read_text(encoding="utf-8")]
BLOCKS = [
    block
    for page in PAGES
    for block in blocks_of(page)
    if block.language == "yaml" and not {"faulty", "fragment"} & block.directives.keys()
]
SCRIPTS = [*sorted((DOCS / "gallery").glob("*.py")), *sorted((DOCS / "notebooks").glob("*.ipynb"))]


def name_of(file: Path) -> str:
    return file.relative_to(ROOT).as_posix()


@pytest.mark.usefixtures("sample_plugins")
@pytest.mark.parametrize("file", [file for file in FILES if file not in SWEEPS], ids=name_of)
def test_a_shipped_scenario_warns_of_yield_only_if_it_is_listed(file: Path) -> None:
    assert warns_beyond_yield(sw.predict(file).warnings) == (name_of(file) in BEYOND_YIELD)


def test_listed_files_exist() -> None:
    assert [name for name in BEYOND_YIELD if not (ROOT / name).is_file()] == []


@pytest.mark.slow
@pytest.mark.parametrize("file", SWEEPS, ids=name_of)
def test_a_shipped_sweep_does_not_warn_of_yield(file: Path, tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as executor:
        assert sw.run_sweep(file, tmp_path / "sweep", executor).failed == 0
    notes = notes_of_sweeps(tmp_path)
    assert len(notes) > 1
    assert not warns_beyond_yield(notes)


@pytest.mark.slow
@pytest.mark.parametrize("block", BLOCKS, ids=str)
def test_a_scenario_of_a_page_warns_of_yield_only_if_it_is_listed(
    block: Block, tmp_path: Path, patch: pytest.MonkeyPatch
) -> None:
    pages.prepare(tmp_path, block, patch)
    file = Path(block.directives.get("file", "scenario.yaml"))
    file.write_text(block.text, encoding="utf-8")
    data = yaml.safe_load(block.text)
    if "sweep" in data or data["chain"].get("elastic_only"):
        return  # the commands of the page run them
    assert not warns_beyond_yield(sw.predict(file).warnings)


@pytest.mark.slow
@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.stem)
def test_an_example_of_gallery_or_notebooks_does_not_warn_of_yield(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        text = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    with tempfile.TemporaryDirectory() as folder:
        monkeypatch.setattr(tempfile, "mkdtemp", lambda: folder)
        names: dict[str, Any] = {"__name__": "example"}
        exec(compile(text, str(file), "exec"), names)
    pyplot.close("all")
    assert not warns_beyond_yield(warnings_of(names.values()))
