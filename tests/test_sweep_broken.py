"""Folders of sweeps that are damaged, or made by somebody else: each is read, or refused in words, and none hangs."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from selection import thinned
from shockwave.cli import main
from shockwave.sweep import plan, runner
from shockwave.sweep.executors import Passed
from shockwave.sweep.results import load_sweep
from shockwave.sweep.runner import run_sweep
from shockwave.sweep.table import write_all

SCENE = """
chain: {material: copper}
shock: {profile: triangular, peak_force: 10 N, rise_time: 10 us, duration_ratio: 3}
predict: {model: section-4}
sweep:
  grid:
    chain.material: [copper, {name: own, youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1e3}]
    chain.diameter: [1 mm, 2 mm, 1e200]
"""
DOCUMENTED = {0, 1, 2, 3, 4, 5}


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


class Here:
    """Runs the trial of a dry run in a thread."""

    def __init__(self, workers: int) -> None:
        self.executor = ThreadPoolExecutor(workers)

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return self.executor.submit(function, *arguments)

    def close(self) -> None:
        self.executor.shutdown()


@pytest.fixture(autouse=True)
def threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps run in a thread: it is their folders that matter here."""
    monkeypatch.setattr(plan, "Processes", Here)
    monkeypatch.setattr(runner, "crew_of", lambda *_: Passed(ThreadPoolExecutor(1), 1))


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
    for options in ([], ["--dry-run"]):
        assert main(["sweep", scene, "--out", str(folder), *options]) == 5
        assert f"{name}: is not a file" in capsys.readouterr().err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no such files here")
@pytest.mark.parametrize("name", ["tables.json", "results.csv.part", "tables.json.part"])
def test_a_pipe_in_place_of_a_file_that_is_written_is_replaced(folder: Path, name: str) -> None:
    (folder / "tables.json").unlink()
    os.mkfifo(folder / name)
    assert folder / "results.csv" in write_all(folder)
    assert json.loads((folder / "tables.json").read_text())["files"]


@pytest.mark.parametrize("name", ["sweep.lock", "journal.jsonl", "results.csv.part"])
def test_nothing_is_written_through_a_link(folder: Path, scene: str, tmp_path: Path, name: str) -> None:
    (tmp_path / "mine").write_text("kept")
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(tmp_path / "mine")
    (folder / "tables.json").unlink()
    assert main(["sweep", scene, "--out", str(folder)]) in (1, 5)
    assert (tmp_path / "mine").read_text() == "kept"


# ---------------------------------------------------------------- what is no header, and no list of tables


def changed(document: Any, path: tuple[Any, ...], value: Any) -> Any:
    inner = document
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    return document


WRONG: dict[str, tuple[tuple[Any, ...], Any]] = {
    "text-for-axes": (("axes",), "abc"),
    "no-axes": (("axes",), []),
    "negative-points": (("points",), -6),
    "many-points": (("points",), 10**30),
    "endless-number": (("axes", 1, "values", 0), [10**400]),
    "truth-for-number": (("axes", 1, "values", 0), [True]),
    "same-variable": (("axes", 0, "names"), ["chain.diameter"]),
    "same-column": (("columns", 0, "name"), "peak_force"),
    "column-of-status": (("columns", 0, "name"), "status"),
    "number-without-unit": (("columns", 0, "unit"), "N"),
    "no-columns": (("columns",), []),
    "versions": (("versions",), [1]),
    "earlier-versions": (("earlier_versions",), 5),
    "not-a-number": (("scenario",), float("nan")),
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


@pytest.mark.parametrize("text", ["", "5", "[" * 5000, '{"files": 5}', '{"files": [[], {}, 5]}'], ids=lambda t: t[:9])
def test_a_list_of_tables_of_a_wrong_shape_is_made_anew(folder: Path, text: str) -> None:
    (folder / "tables.json").write_text(text)
    assert folder / "results.csv" in write_all(folder)


def test_a_journal_of_one_endless_line_is_not_read_into_memory(folder: Path) -> None:
    with (folder / "journal.jsonl").open("wb") as file:
        file.truncate(2**36)  # takes no room on the disk
    with pytest.raises(sw.FileAccessError, match=r"journal\.jsonl: must have lines shorter than 16 MiB"):
        load_sweep(folder)


def test_a_value_that_ends_with_a_nul_keeps_its_name(folder: Path) -> None:
    document = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps(changed(document, ("axes", 0, "values", 0), ["\0"])))
    assert load_sweep(folder).coordinate("chain.material")[0] == r"\x00"
    assert main(["plot", str(folder), "--at", r"chain.material=\x00"]) == 0


def test_invalid_numbers_are_left_out_of_the_results(folder: Path) -> None:
    first, *others = (folder / "journal.jsonl").read_text().splitlines(keepends=True)
    entry = json.loads(first)
    entry["values"] = [float("nan") if isinstance(value, float) else value for value in entry["values"]]
    (folder / "journal.jsonl").write_text("".join([json.dumps(entry) + "\n", *others]))
    assert "lines of the journal that cannot be read: 1" in "; ".join(load_sweep(folder).warnings)


# ---------------------------------------------------------------- whatever it is

VALUES: tuple[Any, ...] = (None, True, -1, 2.5, 1e308, 10**400, 2**63, "", "\0", "\ud800", "=1", [], {}, [1], {"a": 1})


def spoilt(data: bytes, draw: random.Random) -> bytes:
    """Bytes that are cut, changed, or lie twice."""
    at = draw.randrange(len(data))
    changes = (data[:at], data[:at] + bytes([draw.randrange(256)]) + data[at + 1 :], data + data[at:], b"[" * 10**5)
    return draw.choice(changes)


def steps(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where a document has values."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return ([path] if path else []) + [found for key, one in inner for found in steps(one, (*path, key))]


@pytest.mark.parametrize("seed", thinned(range(24), 4))
def test_a_damaged_folder_is_read_or_reported(
    folder: Path, scene: str, seed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = random.Random(seed)
    file = folder / draw.choice(["sweep.json", "sweep.json", "journal.jsonl", "tables.json", "scenario.yaml"])
    if file.suffix == ".json" and draw.random() < 0.8:
        document = json.loads(file.read_text())
        file.write_text(json.dumps(changed(document, draw.choice(steps(document)), draw.choice(VALUES))))
    else:
        file.write_bytes(spoilt(file.read_bytes(), draw))
    commands = [["plot", str(folder), "--at", "chain.material=copper"], ["sweep", scene, "--out", str(folder)]]
    commands += [[*commands[1], "--dry-run", "--accept-versions"]]
    with suppress(sw.ShockwaveError):
        str(load_sweep(folder))
    assert main(draw.choice(commands)) in DOCUMENTED
    told = capsys.readouterr().err
    assert "internal error" not in told
    assert "Traceback" not in told
