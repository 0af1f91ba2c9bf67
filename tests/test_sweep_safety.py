"""What lies in the current folder, other users of the machine, and folders of results can do nothing to a sweep."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from selection import keeping
from shockwave.sweep.workers import workers_of

SCENE = """
name: two sizes
chain: {material: copper}
shock: {profile: triangular, peak_force: 10 N, rise_time: 10 us, duration_ratio: 3}
predict: {model: section-4}
sweep: {grid: {chain.diameter: [1 mm, 1 cm]}}
"""
#: What processes of a sweep import, of the standard library and others.
PLANTED = ("numpy", "yaml", "signal", "multiprocessing", "pickle", "threading", "attrs", "distributed", "shockwave")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    return file


# ---------------------------------------------------------------- the current folder


def unsafe() -> dict[str, str]:
    """The environment of most users, in which nothing keeps the current folder off the path."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}


@pytest.mark.parametrize("executor", keeping(["processes", "dask"], "processes"))
def test_modules_in_the_current_folder_are_not_run(executor: str, scenario: Path, tmp_path: Path) -> None:
    if executor == "dask":
        pytest.importorskip("distributed")
    marker = tmp_path / "marker"
    for name in PLANTED:
        (tmp_path / f"{name}.py").write_text(f"open({str(marker)!r}, 'a').write('{name} ')\n")
    # as a console script does, whose folder, not the current one, is on the path
    program = tmp_path / "bin" / "command.py"
    program.parent.mkdir()
    program.write_text("import sys\nfrom shockwave.cli import main\nif __name__ == '__main__': sys.exit(main())\n")
    command = [sys.executable, str(program), "sweep", "scene.yaml", "--workers", "1", "--executor", executor]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=unsafe())
    assert not marker.exists(), marker.read_text()
    assert run.returncode == 0, run.stderr


def test_a_program_finds_the_modules_in_its_own_folder(scenario: Path, tmp_path: Path) -> None:
    place = tmp_path / "mine"
    place.mkdir()
    (place / "beside.py").write_text("WORKERS = 1\n")
    (place / "program.py").write_text(
        textwrap.dedent(
            f"""
            import beside
            from shockwave.sweep.runner import run_sweep

            if __name__ == "__main__":
                print(run_sweep({str(scenario)!r}, "out", workers=beside.WORKERS).done)
            """
        )
    )
    command = [sys.executable, "mine/program.py"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=unsafe())
    assert run.stdout == "2\n", run.stderr


# ---------------------------------------------------------------- a cluster on this machine


def listening() -> set[tuple[str, int]]:
    """Where this process and its children can be connected to."""
    psutil = pytest.importorskip("psutil")
    me = psutil.Process()
    found = [one for process in (me, *me.children(recursive=True)) for one in process.net_connections("tcp")]
    return {(one.laddr.ip, one.laddr.port) for one in found if one.status == psutil.CONN_LISTEN}


def answer(address: tuple[str, int]) -> bytes:
    """The answer to whoever asks for a page."""
    with socket.create_connection(address, timeout=5) as connection:
        connection.sendall(b"GET /health HTTP/1.0\r\n\r\n")
        try:
            return connection.recv(100)
        except ConnectionError:
            return b""


def test_a_cluster_of_dask_is_closed_to_other_users() -> None:
    distributed: Any = pytest.importorskip("distributed")
    before = listening()
    with workers_of("dask", 1):
        begun = listening() - before
        assert {host for host, _ in begun} == {"127.0.0.1"}
        answers = {address: answer(address) for address in begun}
        assert not [found for found in answers.values() if b" 200 " in found]
        # the others are the servers without pages
        for _, port in (address for address, found in answers.items() if not found.startswith(b"HTTP")):
            with pytest.raises(OSError, match="tcp://127"):
                distributed.Client(f"tcp://127.0.0.1:{port}", timeout=0.5, set_as_default=False)
    assert listening() <= before


@pytest.mark.parametrize("missing", ["cryptography", "distributed"])
def test_packages_that_a_cluster_needs_are_named(
    missing: str, scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(sw.UsageError, match=r"executor dask must be installed .*python -m pip install '.*\[dask\]'"):
        sw.run_sweep(scenario, tmp_path / "out", "dask", workers=1)
