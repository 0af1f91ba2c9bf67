"""The notebooks of the documentation run, and are stored without output."""

import json
from pathlib import Path

import pytest

from support.pages import DOCS

NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
named = pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)


@named
def test_notebooks_are_stored_without_output_and_listed(file: Path) -> None:
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert [cell for cell in code if cell["outputs"] or cell["execution_count"] is not None] == []
    assert f"notebooks/{file.stem}\n" in (DOCS / "notebooks.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # of the packages that run notebooks
@named
def test_notebooks_run(file: Path, tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient")
    book = pytest.importorskip("nbformat").read(file, as_version=4)
    # raises CellExecutionError with the output of the cell
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
