"""Files: read within limits, written completely or not at all, never over an input file."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import shockwave as sw
from shockwave.base.errors import FileAccessError, InvalidValueError
from shockwave.base.files import open_regular, parse_json, read_bytes, read_text, replace_file, write_file
from support.command_line import shockwave
from support.scenario_texts import CHAIN, SHOCK, TABULATED

SCENE = CHAIN + SHOCK.replace("1 us", "10 us")
RECORD = TABULATED % "file: pulse.json"
PULSE = "s N\n0 0\n1e-5 1\n2e-5 0\n"

posix = pytest.mark.skipif(os.name != "posix", reason="links, pipes and permissions of POSIX")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a scenario and a record."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "record.yaml").write_text(RECORD, encoding="utf-8")
    (tmp_path / "pulse.json").write_text(PULSE, encoding="utf-8")
    return tmp_path


# ---------------------------------------------------------------- reading


def test_a_number_is_no_path() -> None:
    with pytest.raises(InvalidValueError, match=r"^path: must be the path of a file .got 3"):
        sw.load_scenario(3)  # type: ignore[arg-type]


def test_a_larger_file_than_the_limit_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12345")
    assert (read_text(tmp_path / "a", 5), read_bytes(tmp_path / "a", 5)) == ("12345", b"12345")
    with pytest.raises(FileAccessError, match=r"a: must be at most 4 bytes \(got more; cut it\)"):
        read_bytes(tmp_path / "a", 4, "cut it")


@pytest.mark.parametrize("text", ["[" * 100_000, "", "{", "[NaN]"], ids=lambda text: text[:5])
def test_invalid_json_is_refused(text: str) -> None:
    with pytest.raises(InvalidValueError, match=r"sweep: must be JSON.*; mend it\)"):
        parse_json(text, "sweep", "mend it")


@posix
@pytest.mark.parametrize("file", ["scene.yaml", "pulse.json"])
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_scenarios_and_records_are_regular_files(file: str, kind: str, folder: Path) -> None:
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


# ---------------------------------------------------------------- writing


@posix
def test_a_link_is_replaced_and_never_written_through(tmp_path: Path) -> None:
    (tmp_path / "other").write_bytes(b"kept")
    (tmp_path / "a").symlink_to("other")
    with pytest.raises(FileAccessError, match=r"a: is not a file \(got a link; delete it\)"):
        open_regular(tmp_path / "a", mode="r+b")
    with replace_file(tmp_path / "a") as file:
        file.write("new")
    assert ((tmp_path / "other").read_bytes(), (tmp_path / "a").read_bytes()) == (b"kept", b"new")


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that is full as soon as something is written."""

    def fail(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fail)


WRITERS = {
    "report": "report scene.yaml -o old.html",
    "schema": "schema -o old.json",
    "curve": "curve scene.yaml --rtol 1e-2 --longest 1 -o old.json",
    "spectrum": "spectrum scene.yaml --set chain.granules=4 --mass 1 --from 1e3 --to 1e3 -o old.csv",
    "design": "design scene.yaml --vary chain.radius --between 1mm 3mm --target amplification=0.5 -o old.pdf",
    "bench": "bench scene.yaml --quick --family quadratures --timeout 1e-3 -o old.html",
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_command_leaves_the_old_file_on_a_full_disk(
    name: str, folder: Path, full: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {})  # pages without pictures
    arguments = WRITERS[name].split()
    old = folder / arguments[-1]
    old.write_text("old")
    before = sorted(folder.iterdir())
    answer = shockwave(*arguments)
    assert answer.status == 5
    assert f"{old.name}: cannot be written (No space left on device)" in answer.err
    assert old.read_text() == "old"
    assert sorted(folder.iterdir()) == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_device_is_written_to_directly_and_may_be_full() -> None:
    answer = shockwave("schema", "-o", "/dev/full")
    assert answer.status == 5
    assert "/dev/full: cannot be written (No space left on device)" in answer.err
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)


@posix
@pytest.mark.parametrize("place", ["old", "missing"])
def test_a_link_stays_and_its_target_is_written(folder: Path, place: str) -> None:
    (folder / "inner").mkdir()
    (folder / "inner" / "old").write_text("old")
    (folder / "link").symlink_to(Path("inner") / place)
    write_file("link", "new")
    assert (folder / "link").is_symlink()
    assert (folder / "inner" / place).read_text() == "new"


@posix
def test_permissions_are_those_of_the_old_file_or_follow_the_umask(folder: Path) -> None:
    (folder / "old").touch(0o600)
    before = os.umask(0o027)
    try:
        write_file("old", "new")
        write_file("new", "new")
    finally:
        os.umask(before)
    assert [stat.S_IMODE((folder / name).stat().st_mode) for name in ("old", "new")] == [0o600, 0o640]


@pytest.mark.parametrize("place", ["nowhere/new", ".", "x" * 999], ids=["folder", "directory", "long"])
def test_a_place_that_cannot_be_written_is_a_file_access_error(folder: Path, place: str) -> None:
    with pytest.raises(FileAccessError, match="cannot be written"):
        write_file(place, "new")


# ---------------------------------------------------------------- inputs


@pytest.mark.parametrize("command", ["report", "curve", "design", "bench"])
@pytest.mark.parametrize("taken", ["scenario", "link", "record"])
def test_an_input_file_is_not_overwritten(
    command: str, taken: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, target = ("record.yaml", "pulse.json") if taken == "record" else ("scene.yaml", "scene.yaml")
    ending = {"curve": ".json", "design": ".svg"}.get(command, ".html")
    design = ["--vary", "chain.radius", "--target", "amplification=1", "--between", "1mm", "2mm"]
    if taken == "link":
        (folder / f"out{ending}").symlink_to(target)
    else:  # a name that the command takes for an output
        (folder / f"out{ending}").hardlink_to(target)
    monkeypatch.setattr("shockwave.UniversalCurve.__init__", None)  # nothing is computed
    answer = shockwave(command, scene, "-o", f"out{ending}", *(design if command == "design" else []))
    assert answer.status == 2
    for part in ("--output: must not be an input file", f"got out{ending}, which is ", target):
        assert part in answer.err
    assert ((folder / "scene.yaml").read_text(), (folder / "pulse.json").read_text()) == (SCENE, PULSE)


def test_a_stream_that_is_a_file_is_appended_to(tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text("old\n")
    program = "from shockwave.base.files import write_file; write_file('/dev/stdout', 'new')"
    with log.open("a") as stream:
        subprocess.run([sys.executable, "-c", program], stdout=stream, check=True)
    assert log.read_text() == "old\nnew"
