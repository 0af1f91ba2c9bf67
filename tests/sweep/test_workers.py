"""Crashes, interrupts and time limits: every point is run once, and the results do not change."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import groupby
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from test_runner import journal, swept, tables

import shockwave as sw
from shockwave.sweep.progress_text import SweepReport
from shockwave.sweep.runner import run_sweep
from shockwave.sweep.workers import LostError

if TYPE_CHECKING:
    from conftest import Install

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes are killed by signals")

#: A pulse that crashes, hangs or raises an error for some values of its parameter.
RISKY = """
import os, time
from attrs import frozen
from shockwave import quantity
from shockwave.profiles.triangular import Triangular

@frozen(kw_only=True)
class Pulse(Triangular):
    danger: float = quantity("", "value that causes an error", default=0.0)

    def rise(self, s):
        if self.danger == 5:
            os.abort()
        if self.danger == 70 and not os.path.exists(MARKER):  # the first time
            open(MARKER, "w").close()
            os.abort()
        if self.danger == 60:
            time.sleep(600)
        if self.danger == 9:
            raise RuntimeError("out of order")
        return super().rise(s)
"""
SCENE = """
chain: {{material: paper-steel, diameter: 9.5 mm}}
shock: {{profile: {profile}, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3}}
simulate: {{rtol: 1e-4}}
sweep: {{zip: {{{sweep}, shock.rise_time: {{linspace: [2 us, 6 us, {count}]}}}}}}
"""


def written(folder: Path, count: int, profile: str = "triangular", sweep: str = "") -> Path:
    file = folder / "scene.yaml"
    sweep = sweep or f"shock.peak_force: {{linspace: [90, 110, {count}]}}"
    file.write_text(SCENE.format(profile=profile, count=count, sweep=sweep))
    return file


def risky(folder: Path, install: Install, *dangers: int) -> Path:
    """A sweep over values of the parameter."""
    install("risky", pulse=RISKY.replace("MARKER", repr(str(folder / "crashed"))))
    return written(folder, len(dangers), "risky", f"shock.parameters.danger: {list(dangers)}")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """Enough points for many batches."""
    return written(tmp_path, 1200)


def undisturbed(file: Path, folder: Path) -> dict[str, bytes]:
    swept(file, folder)
    return tables(folder)


def unfinished(folder: Path) -> dict[int, str]:
    """Status of each point without a result."""
    return {line["index"]: line["status"] for line in journal(folder) if line["status"] != "done"}


def once(strike: Callable[[], object], after: int = 8) -> Callable[[SweepReport], None]:
    """A progress function that calls ``strike`` once, when so many points are done."""
    struck = []

    def progress(report: SweepReport) -> None:
        if report.done >= after and not struck:
            struck.append(strike())

    return progress


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    # a zombie process does not count
    stat = Path(f"/proc/{pid}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] != "Z"


# ---------------------------------------------------------------- workers and clients


def test_a_killed_worker_loses_no_results(scenario: Path, tmp_path: Path) -> None:
    before = set(multiprocessing.active_children())

    def strike() -> None:
        time.sleep(0.2)  # until the worker runs its next batch
        next(child for child in multiprocessing.active_children() if child not in before).kill()

    report = run_sweep(scenario, tmp_path / "out", workers=2, progress=once(strike))
    assert (report.done, report.crashed) == (1200, 0)
    assert sorted(line["index"] for line in journal(tmp_path / "out")) == list(range(1200))
    assert tables(tmp_path / "out") == undisturbed(scenario, tmp_path / "whole")


CLIENT = """
import multiprocessing, os, signal, sys
from shockwave.sweep import runner
signal.signal(signal.SIGINT, {interrupt})
if hasattr(signal, "SIGHUP"):  # ignored by what was started with nohup
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
def strike(report):
    if 0 < report.done < report.points:
        print(*(child.pid for child in multiprocessing.active_children()), flush=True)
        for _ in range({times}):
            os.kill(os.getpid(), {number:d})
run_sweep = runner.run_sweep
runner.run_sweep = lambda *places, **settings: run_sweep(*places, **settings | {{"progress": strike}})
from shockwave.cli import main
sys.exit(main(["sweep", *sys.argv[1:]]))
"""


def struck(scenario: Path, out: Path, number: int, times: int, interrupt: str) -> subprocess.CompletedProcess[str]:
    """A client that receives signals when some points are done, and prints the process ids of its workers."""
    program = CLIENT.format(number=number, times=times, interrupt=interrupt)
    command = [sys.executable, "-c", program, str(scenario), "--output", str(out), "--workers", "2"]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.mark.slow
def test_a_killed_client_loses_no_results_and_leaves_no_worker(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = struck(scenario, out, signal.SIGKILL, 1, "signal.default_int_handler")
    assert run.returncode == -signal.SIGKILL
    begun = len(journal(out))
    assert 0 < begun < 1200
    pids = [int(pid) for pid in run.stdout.split()]
    assert len(pids) == 2
    deadline = time.monotonic() + 600  # generous, for a busy machine
    while any(map(alive, pids)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(alive, pids))
    with ThreadPoolExecutor(1) as executor:
        assert run_sweep(scenario, out, executor).before == begun
    assert sorted(line["index"] for line in journal(out)) == list(range(1200))
    assert tables(out) == undisturbed(scenario, tmp_path / "whole")


@pytest.mark.parametrize(
    ("name", "times", "interrupt"),
    [
        ("SIGTERM", 1, "signal.default_int_handler"),
        ("SIGINT", 1, "signal.default_int_handler"),
        # as `timeout` sends it, to a process and then to its group
        pytest.param("SIGTERM", 2, "signal.default_int_handler", marks=pytest.mark.slow),
        # as in a background process of a shell
        pytest.param("SIGTERM", 1, "signal.SIG_IGN", marks=pytest.mark.slow),
        pytest.param("SIGHUP", 1, "signal.default_int_handler", marks=pytest.mark.slow),
    ],
    ids=["SIGTERM", "SIGINT", "twice", "background", "SIGHUP"],
)
def test_signals_stop_a_sweep_like_an_interrupt(
    scenario: Path, tmp_path: Path, name: str, times: int, interrupt: str
) -> None:
    out, number = tmp_path / "out", getattr(signal, name)
    run = struck(scenario, out, number, times, interrupt)
    assert run.returncode == 128 + number, run.stderr
    finished = len(journal(out))
    assert 0 < finished < 1200
    assert run.stderr == f"interrupted: {finished} of 1200 points are saved; run the same command to resume\n"
    assert not any(map(alive, map(int, run.stdout.split())))


#: Modules that the processes of a sweep import.
PLANTED = ("numpy", "yaml", "signal", "multiprocessing", "pickle", "threading", "attrs", "shockwave")


def test_modules_in_the_current_folder_are_not_run(tmp_path: Path) -> None:
    written(tmp_path, 2)
    marker = tmp_path / "marker"
    for name in PLANTED:
        (tmp_path / f"{name}.py").write_text(f"open({str(marker)!r}, 'a').write('{name} ')\n")
    # like a console script, which has its own folder on the path, not the current one
    program = tmp_path / "bin" / "command.py"
    program.parent.mkdir()
    program.write_text("import sys\nfrom shockwave.cli import main\nif __name__ == '__main__': sys.exit(main())\n")
    command = [sys.executable, str(program), "sweep", "scene.yaml", "--workers", "1"]
    usual = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=usual)
    assert not marker.exists(), marker.read_text()
    assert run.returncode == 0, run.stderr


def small(folder: Path) -> Path:
    """A file with a sweep of two points."""
    folder.mkdir()
    return written(folder, 2)


def commanded(file: Path, limits: Callable[[], object] | None = None, **environment: str) -> Any:
    command = [sys.executable, "-m", "shockwave", "sweep", file.name, "--workers", "1", "--output", "out"]
    return subprocess.run(
        command, cwd=file.parent, capture_output=True, text=True, env=os.environ | environment, preexec_fn=limits
    )


def test_a_long_folder_of_temporary_files_does_not_stop_a_sweep(tmp_path: Path) -> None:
    # no path of a socket in it is short enough
    long = tmp_path / ("long" * 30)
    long.mkdir()
    run = commanded(small(tmp_path / "sweep"), TMPDIR=str(long))
    assert (run.returncode, run.stderr) == (0, "")
    assert "2 of 2 points done" in run.stdout


def test_too_few_open_files_are_reported(tmp_path: Path) -> None:
    import resource  # not on Windows

    run = commanded(small(tmp_path / "sweep"), lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (12, 12)))
    assert run.returncode == 1
    assert re.fullmatch(r"the limit of open files must be at least (\d+) \(got 12; use `ulimit -n \1`\)\n", run.stderr)


def test_sweeps_in_threads_run_one_after_the_other(tmp_path: Path) -> None:
    files = [small(tmp_path / str(number)) for number in range(4)]
    order: list[Path] = []

    def run(file: Path) -> int:
        return run_sweep(file, file.parent / "out", workers=1, progress=lambda report: order.append(report.folder)).done

    with ThreadPoolExecutor(len(files)) as threads:
        assert list(threads.map(run, files)) == [2] * len(files)
    assert len(list(groupby(order))) == len(files)


# ---------------------------------------------------------------- points


def test_only_the_point_that_crashes_is_recorded_as_crashed(tmp_path: Path, install: Install) -> None:
    file = risky(tmp_path, install, *range(12))
    report = run_sweep(file, tmp_path / "out", workers=2)
    assert (report.done, report.failed, report.crashed, report.exit_code) == (10, 1, 1, 1)
    assert unfinished(tmp_path / "out") == {5: "crashed", 9: "failed"}
    # neither is run again
    assert run_sweep(file, tmp_path / "out").before == 12


def test_a_point_whose_process_ends_once_is_run_again_before_it_is_blamed(tmp_path: Path, install: Install) -> None:
    # two points are sent alone
    file = risky(tmp_path, install, 0, 70)
    report = run_sweep(file, tmp_path / "out", workers=1)
    assert (report.done, report.crashed) == (2, 0)
    assert (tmp_path / "crashed").exists()


def test_fail_fast_stops_at_a_point_that_crashes(tmp_path: Path, install: Install) -> None:
    file = risky(tmp_path, install, 0, 5, *[0] * 200)
    report = run_sweep(file, tmp_path / "out", workers=1, fail_fast=True)
    assert (report.failed, report.crashed) == (0, 1)
    assert report.left > 0


def test_only_the_points_that_exceed_the_time_limit_fail(tmp_path: Path, install: Install) -> None:
    file = risky(tmp_path, install, 0, 1, 60, 3, 4, 60, 6)
    report = run_sweep(file, tmp_path / "out", workers=2, timeout=3.0)
    assert (report.done, report.failed, report.exit_code) == (5, 2, 1)
    assert unfinished(tmp_path / "out") == {2: "failed", 5: "failed"}
    errors = {line["error"] for line in journal(tmp_path / "out") if line["status"] == "failed"}
    assert errors == {"must take at most 3 s (was stopped; increase --timeout)"}


# ---------------------------------------------------------------- executors


PROCESSES = r"^executor: must be a concurrent\.futures\.Executor \(got "
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "number": ({"executor": 3}, PROCESSES),
    "name": ({"executor": "processes"}, PROCESSES + "'processes'"),
    "client": ({"executor": SimpleNamespace(get_executor=None)}, rf"{PROCESSES}.*; its get_executor\(\) is one\)"),
    "workers": ({"workers": "2"}, "^workers: must be"),
    "no time": ({"timeout": 0}, r"timeout: must be > 0 s \(got"),
    "not a number": ({"timeout": float("nan")}, r"timeout: must be > 0 s \(got"),
    "mass": ({"timeout": "5 kg"}, r"timeout: must be a time, such as '15 us' \(got"),
    "threads": ({"executor": ThreadPoolExecutor(1), "timeout": 1.0}, "timeout: must be omitted with an executor"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_setting_is_refused_before_anything_is_written(scenario: Path, tmp_path: Path, case: str) -> None:
    settings, message = REFUSED[case]
    with pytest.raises((sw.UsageError, sw.InvalidValueError), match=message):
        run_sweep(scenario, tmp_path / "out", **settings)
    assert not (tmp_path / "out").exists()


def test_a_broken_executor_of_the_caller_is_reported(scenario: Path, tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    before = set(multiprocessing.active_children())

    def strike() -> None:
        for child in set(multiprocessing.active_children()) - before:
            child.kill()

    with (
        ProcessPoolExecutor(1, mp_context=context) as executor,
        pytest.raises(LostError, match="finished points are kept"),
    ):
        run_sweep(scenario, tmp_path / "out", executor, progress=once(strike))
    assert len(journal(tmp_path / "out")) >= 8


def test_a_program_without_a_main_guard_is_refused_with_a_hint(scenario: Path, tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(f"import shockwave as sw\nsw.run_sweep({str(scenario)!r}, {str(tmp_path / 'out')!r})\n")
    run = subprocess.run([sys.executable, program], capture_output=True, text=True)
    assert "LostError: worker processes must start" in run.stderr
    assert "if __name__ == '__main__':" in run.stderr


class Elsewhere(ThreadPoolExecutor):
    """Workers with another version of shockwave."""

    def submit(self, function: Any, /, *arguments: Any, **named: Any) -> Any:
        def run() -> Any:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(sw, "__version__", "0.0.9")
                return function(*arguments, **named)

        return super().submit(run)


def test_a_worker_with_another_version_is_refused(scenario: Path, tmp_path: Path) -> None:
    with (
        Elsewhere(1) as executor,
        pytest.raises(sw.UsageError, match=r"got a worker with versions\.shockwave '0\.0\.9', now "),
    ):
        run_sweep(scenario, tmp_path / "out", executor)
    assert journal(tmp_path / "out") == []
