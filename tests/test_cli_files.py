"""Files: written whole or not at all, never over what is read, named by patterns, read within limits."""

from __future__ import annotations

import errno
import os
import stat
import threading
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from shockwave import output
from shockwave.cli import main
from shockwave.errors import FileAccessError
from shockwave.output import write_file

SCENE = """\
chain: {material: copper, radius: 1 mm}
shock: {profile: triangular, peak_force: 1 N, rise_time: 10 us, duration_ratio: 2}
"""
RECORD = """\
chain: {material: copper, radius: 1 mm}
shock: {profile: tabulated, parameters: {file: pulse.json}}
"""
PULSE = "0 0\n1e-5 1\n2e-5 0\n"

posix = pytest.mark.skipif(os.name != "posix", reason="links, pipes and permissions of POSIX")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a scenario and a record."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "record.yaml").write_text(RECORD, encoding="utf-8")
    (tmp_path / "pulse.json").write_text(PULSE, encoding="utf-8")
    return tmp_path


# ---------------------------------------------------------------- written whole or not at all


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that is full once a file has been begun."""

    class Full:
        def __init__(self, file: Any) -> None:
            self.file = file

        def __enter__(self) -> Full:
            return self

        def __exit__(self, *_: object) -> None:
            self.file.close()

        def write(self, data: bytes) -> None:
            self.file.write(data[:3])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(output, "open", lambda *given: Full(open(*given)), raising=False)  # noqa: SIM115


def test_on_a_full_disk_the_old_file_stays_and_nothing_else(folder: Path, full: None) -> None:
    (folder / "old").write_text("old")
    before = sorted(folder.iterdir())
    with pytest.raises(FileAccessError, match=r"^old: cannot be written \(No space left on device\)$"):
        write_file("old", "new")
    assert (folder / "old").read_text() == "old"
    assert sorted(folder.iterdir()) == before


WRITERS = {
    "report": ["report", "scene.yaml", "-o", "old.html"],
    "schema": ["schema", "-o", "old.json"],
    "curve": ["curve", "scene.yaml", "--rtol", "1e-2", "--longest", "1", "-o", "old.json"],
    "curve-drawn": ["curve", "scene.yaml", "--rtol", "1e-2", "--longest", "1", "-o", "old.png"],
    "design": [
        *("design", "scene.yaml", "--vary", "chain.radius", "--target", "amplification=0.5", "--rtol", "1e-2"),
        *("--between", "1 mm", "3 mm", "--points", "3", "-o", "old.pdf"),
    ],
    "bench": ["bench", "scene.yaml", "--quick", "--family", "quadratures", "--longest", "1e-3", "-o", "old.html"],
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_command_leaves_the_old_file_on_a_full_disk(
    name: str, folder: Path, full: None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # pages are written without their pictures
    monkeypatch.setattr("shockwave.page.whole.drawn", lambda _: "")
    monkeypatch.setattr("shockwave.benchmark.bench_page._drawing", lambda *_: "")
    old = folder / WRITERS[name][-1]
    old.write_text("old")
    assert main(WRITERS[name]) == 5
    assert f"{old.name}: cannot be written (No space left on device)" in capsys.readouterr().err
    assert old.read_text() == "old"
    assert list(folder.glob(".*")) == []


def test_a_plot_leaves_the_old_file_on_a_full_disk(folder: Path, full: None) -> None:
    from shockwave.pictures import figure, save

    (folder / "old.svg").write_text("old")
    with pytest.raises(FileAccessError, match="No space left"):
        save(figure()[0], "old.svg")
    assert (folder / "old.svg").read_text() == "old"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_device_is_written_to_directly_and_may_be_full(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "-o", "/dev/full"]) == 5
    assert "/dev/full: cannot be written (No space left on device)" in capsys.readouterr().err
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)


@posix
def test_a_pipe_is_written_to_directly(folder: Path) -> None:
    os.mkfifo("pipe")
    found: list[str] = []
    reader = threading.Thread(target=lambda: found.append(Path("pipe").read_text()))
    reader.start()
    write_file("pipe", "through")
    reader.join()
    assert found == ["through"]
    assert stat.S_ISFIFO(Path("pipe").stat().st_mode)


@posix
@pytest.mark.parametrize("place", ["old", "missing"])
def test_a_link_stays_and_what_it_points_to_is_written(folder: Path, place: str) -> None:
    (folder / "inner").mkdir()
    (folder / "inner" / "old").write_text("old")
    (folder / "link").symlink_to(Path("inner") / place)
    write_file("link", "new")
    assert (folder / "link").is_symlink()
    assert (folder / "inner" / place).read_text() == "new"
    assert sorted(each.name for each in (folder / "inner").iterdir()) == sorted({"old", place})


@posix
def test_permissions_of_a_file_are_kept(folder: Path) -> None:
    (folder / "old").write_text("old")
    (folder / "old").chmod(0o640)
    write_file("old", "new")
    assert stat.S_IMODE((folder / "old").stat().st_mode) == 0o640


@posix
def test_permissions_of_a_new_file_follow_the_umask(folder: Path) -> None:
    before = os.umask(0o027)
    try:
        write_file("new", "new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((folder / "new").stat().st_mode) == 0o640


def test_a_new_scenario_replaces_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "-o", "scene.yaml"]) == 5
    assert "it exists already" in capsys.readouterr().err
    assert (folder / "scene.yaml").read_text() == SCENE


@pytest.mark.parametrize("place", ["nowhere/new", ".", "a\0b", "x" * 999])
def test_what_cannot_be_written_is_a_file_access_error(folder: Path, place: str) -> None:
    with pytest.raises(FileAccessError):
        write_file(place, "new")


# ---------------------------------------------------------------- never over what is read


@pytest.mark.parametrize("command", ["report", "curve", "design", "bench"])
@pytest.mark.parametrize("taken", ["scenario", "link", "record"])
def test_an_input_file_is_not_overwritten(
    command: str, taken: str, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, target = ("record.yaml", "pulse.json") if taken == "record" else ("scene.yaml", "scene.yaml")
    ending = {"report": ".html", "curve": ".json", "design": ".svg", "bench": ".html"}[command]
    if taken == "link":
        (folder / f"out{ending}").symlink_to(target)
    else:  # a name that the command takes for an output
        (folder / f"out{ending}").hardlink_to(target)
    monkeypatch.setattr("shockwave.studies.universal_curve.UniversalCurve.__init__", None)  # nothing is computed
    design = ["--vary", "chain.radius", "--target", "amplification=1", "--between", "1mm", "2mm"]
    assert main([command, scene, "-o", f"out{ending}", *(design if command == "design" else [])]) == 2
    error = capsys.readouterr().err
    assert "--output: must not be an input file" in error
    assert f"out{ending}" in error
    assert target in error
    assert (folder / "scene.yaml").read_text() == SCENE
    assert (folder / "pulse.json").read_text() == PULSE


# ---------------------------------------------------------------- patterns


def test_a_pattern_is_expanded_in_order(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "*.yaml"]) == 0
    assert capsys.readouterr().out == "record.yaml: valid\nscene.yaml: valid\n"


def test_a_pattern_that_matches_nothing_is_a_missing_file_and_hides_no_other_result(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["validate", "*.yml", "scene.yaml"]) == 5
    shown = capsys.readouterr().out
    assert "*.yml: cannot be read (got No such file or directory)" in shown
    assert "scene.yaml: valid" in shown


@posix
def test_a_file_whose_name_is_a_pattern_is_that_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "[rs]*.yaml").write_text(SCENE)
    assert main(["validate", "[rs]*.yaml"]) == 0
    assert capsys.readouterr().out == "[rs]*.yaml: valid\n"


# ---------------------------------------------------------------- read within limits


@posix
@pytest.mark.parametrize("file", ["scene.yaml", "pulse.json"])
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_only_regular_files_are_read(file: str, kind: str, folder: Path) -> None:
    (folder / file).unlink()
    if kind == "pipe":
        os.mkfifo(file)
    elif kind == "device":
        (folder / file).symlink_to("/dev/zero")
    else:
        (folder / file).mkdir()
    # a record must lie in the scenario's folder, links resolved
    error = sw.ScenarioError if (file, kind) == ("pulse.json", "device") else FileAccessError
    with pytest.raises(error, match=r"is not a file|must be a file in the scenario's folder"):
        sw.load_scenario("record.yaml" if file == "pulse.json" else file)


@pytest.mark.parametrize(
    ("file", "size", "error"),
    [("scene.yaml", 2**20 + 1, FileAccessError), ("pulse.json", 128 * 2**20 + 1, FileAccessError)],
)
def test_a_file_that_is_too_large_is_not_read(file: str, size: int, error: type[Exception], folder: Path) -> None:
    with (folder / file).open("r+b") as opened:
        opened.truncate(size)
    with pytest.raises(error, match=r"must be at most \d+ MiB"):
        sw.load_scenario("record.yaml" if file == "pulse.json" else file)
