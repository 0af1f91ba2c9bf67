"""Folders of sweeps that are damaged, or made by somebody else: each is read, or refused in words, and none hangs."""

from __future__ import annotations

import json
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from shockwave.cli import main
from shockwave.sweep import plan, runner
from shockwave.sweep.results import load_sweep
from shockwave.sweep.runner import run_sweep
from shockwave.sweep.workers import Workers

SCENE = """
chain: {material: copper}
shock: {profile: triangular, peak_force: 10 N, rise_time: 10 us, duration_ratio: 3}
predict: {model: section-4}
sweep:
  grid:
    chain.material: [copper, lead]
    chain.diameter: [1 mm, 2 mm, 1e200]
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario, and beside it the folder of its sweep."""
    place = tmp_path_factory.mktemp("made")
    (place / "scene.yaml").write_text(SCENE)
    with ThreadPoolExecutor(1) as executor:
        assert run_sweep(place / "scene.yaml", place / "out", executor).points == 6
    return place


@pytest.fixture
def scene(made: Path) -> str:
    return str(made / "scene.yaml")


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made / "out", tmp_path / "out"))


@pytest.fixture(autouse=True)
def threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps run in a thread: it is their folders that matter here."""
    monkeypatch.setattr(plan, "_timed_apart", lambda _: None)
    monkeypatch.setattr(runner, "workers_of", lambda *_: nullcontext(Workers(ThreadPoolExecutor(1), 1)))


# ---------------------------------------------------------------- what is no file


def pipe(file: Path) -> None:
    os.mkfifo(file)


def device(file: Path) -> None:
    file.symlink_to("/dev/zero")


def nested(file: Path) -> None:
    file.mkdir()


@pytest.mark.skipif(not (hasattr(os, "mkfifo") and os.path.exists("/dev/zero")), reason="there are no such files here")
@pytest.mark.parametrize("name", ["sweep.json", "journal.jsonl"])
@pytest.mark.parametrize("kind", [pipe, device, nested])
def test_only_regular_files_are_read(
    folder: Path, scene: str, name: str, kind: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / name).unlink()
    kind(folder / name)
    with pytest.raises(sw.FileAccessError, match=f"{name}: is not a file"):
        load_sweep(folder)
    assert main(["sweep", scene, "--out", str(folder), "--dry-run"]) == 5
    assert f"{name}: is not a file" in capsys.readouterr().err


# ---------------------------------------------------------------- what is no header


def changed(document: Any, path: tuple[Any, ...], value: Any) -> Any:
    inner = document
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    return document


WRONG: dict[str, tuple[tuple[Any, ...], Any]] = {
    "text-for-axes": (("axes",), "abc"),
    "no-axes": (("axes",), []),
    "many-points": (("points",), 10**30),
    "other-shape": (("shape",), [3, 2]),
    "words-for-numbers": (("axes", 1, "values", 0), ["two"]),
    "versions": (("versions",), [1]),
    "not-a-number": (("scenario",), float("nan")),
    "other-format": (("format",), 2),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_header_of_a_wrong_shape_is_refused(
    folder: Path, scene: str, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps(changed(document, *WRONG[name])))
    with pytest.raises(sw.InvalidValueError, match=r"sweep\.json: must "):
        load_sweep(folder)
    assert main(["sweep", scene, "--out", str(folder), "--accept-versions"]) == 3
    assert "sweep.json: must " in capsys.readouterr().err


def test_a_journal_of_one_endless_line_is_not_read_into_memory(folder: Path) -> None:
    with (folder / "journal.jsonl").open("wb") as file:
        file.truncate(2**36)  # takes no room on the disk
    with pytest.raises(sw.FileAccessError, match=r"journal\.jsonl: must have lines shorter than 16 MiB"):
        load_sweep(folder)
