"""Random cases for the command line: mutated scenarios, records and results, and command lines of random options.

    python tests/fuzz.py 5000 --seed 1

runs so many cases in processes of their own and prints those that fail, each with what repeats it. A case must end
with a documented status, without a traceback or an internal error, within ten seconds of processor time and 500 MB more
than the program itself takes, must print JSON where it is asked to, and must leave what it reads as it was. A case
follows from its seed and number alone.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import queue
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from fuzz_cases import KINDS, Case, case_of

ROOT = Path(__file__).parent.parent
#: What a worker runs.
PROGRAM: tuple[str, ...] = (__file__,)
#: What a case may take: processor time [s], and memory beyond that of the program with all its parts loaded [bytes].
MOST_SECONDS, MOST_MEMORY = 10, 500 * 10**6
#: A case that waits for something for so long hangs [s]; a busy machine does not take so long.
_HANGS = 300.0
_STATUSES = {0, 1, 2, 3, 4, 5, 130}
_WRONG = re.compile(r"Traceback \(most recent|internal error|[A-Z]\w+Warning:")


@frozen
class Outcome:
    """How a case ended: its status, processor time [s], greatest memory beyond the program's [bytes], what is wrong."""

    number: int
    status: int | None
    seconds: float
    memory: int
    wrong: str = ""


# ---------------------------------------------------------------- a worker


def _peak() -> int:
    """The greatest memory of this process since it was last cleared [bytes]."""
    with contextlib.suppress(OSError), open("/proc/self/status") as file:
        return 1024 * int(re.search(r"VmHWM:\s+(\d+)", file.read())[1])  # type: ignore[index]
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _clear_peak() -> None:
    with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def _memory_now() -> int:
    with contextlib.suppress(OSError), open("/proc/self/statm") as file:
        return int(file.read().split()[0]) * resource.getpagesize()
    return 0


def _answer(number: int, case: Case) -> Outcome:
    """Run a case in the current process, in a folder of its own."""
    from shockwave.cli import main

    with tempfile.TemporaryDirectory() as folder, open(os.path.join(folder, "printed"), "w+b") as printed:
        place = Path(folder) / "here"
        place.mkdir()
        for name, content in case.files.items():
            (place / name).parent.mkdir(exist_ok=True)
            (place / name).write_bytes(content)
        errors = open(os.path.join(folder, "errors"), "w+b")  # noqa: SIM115
        os.dup2(printed.fileno(), 1)
        os.dup2(errors.fileno(), 2)
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        os.chdir(place)
        _clear_peak()
        before, begun, wrong = _peak(), time.process_time(), ""
        try:
            status: Any = main(case.arguments)
        except SystemExit as end:
            status = end.code or 0
        except BaseException as error:
            status, wrong = None, f"raised {type(error).__name__}: {error}"
        seconds, memory = time.process_time() - begun, _peak() - before
        with contextlib.suppress(OSError):
            sys.stdout.flush()
        sys.stderr.flush()
        os.chdir(ROOT)
        out, err = ((Path(folder) / name).read_bytes().decode("utf-8", "replace") for name in ("printed", "errors"))
        errors.close()
        changed = [name for name in _read(case) if not _is(place / name, case.files[name])]
        wrong = wrong or _wrong(case, status, out, err, changed)
    return Outcome(number, status, seconds, memory, wrong)


def _read(case: Case) -> set[str]:
    """The files that a case may read: those that it names other than as its output, and the records that they name."""
    named = {
        given
        for option, given in zip(("", *case.arguments), case.arguments, strict=False)
        if option not in ("-o", "--output", "--out")
    }
    if named & {"scene.yaml", "record.yaml", "*.yaml"}:
        named |= {"hammer.csv"}
    return set(case.files) if "*.yaml" in named else named & set(case.files)


def _is(file: Path, content: bytes) -> bool:
    try:
        return file.read_bytes() == content
    except OSError:
        return False


def _wrong(case: Case, status: Any, out: str, err: str, changed: list[str]) -> str:
    if status not in _STATUSES:
        return f"status {status!r}"
    found = _WRONG.search(err) or _WRONG.search(out if "--json" not in case.arguments else "")
    if found:
        return f"{(err + out)[-1500:]}"
    if changed:
        return f"changed {changed}"
    if "--json" in case.arguments and status == 0 and not {"--help", "-h", "--version"} & set(case.arguments):
        try:
            json.loads(out, parse_constant=_no_number)
        except ValueError as error:
            return f"no JSON: {error}: {out[:200]}"
    return ""


def _no_number(name: str) -> None:
    raise ValueError(name)


def _work(seed: int, kinds: Sequence[str]) -> None:
    """Answer numbers of cases, a line each, until there are no more."""
    # so that loading them counts for no case
    importlib.import_module("matplotlib.figure")
    importlib.import_module("scipy.optimize")

    answers = os.fdopen(os.dup(1), "w")
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    for line in sys.stdin:
        number = int(line)
        case = case_of(seed, number, kinds)
        used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        resource.setrlimit(resource.RLIMIT_CPU, (int(used) + MOST_SECONDS + 1, hard))
        resource.setrlimit(resource.RLIMIT_AS, (_memory_now() + MOST_MEMORY + 64 * 2**20, resource.RLIM_INFINITY))
        outcome = _answer(number, case)
        print(json.dumps(asdict(outcome)), file=answers, flush=True)


# ---------------------------------------------------------------- all cases


class _Worker:
    """A process that answers cases one after another."""

    def __init__(self, seed: int, kinds: Sequence[str], scratch: str) -> None:
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "XDG_CACHE_HOME": scratch, "MPLCONFIGDIR": scratch}
        environment["PYTHONPATH"] = str(Path(__file__).parent)  # a safe path leaves out the folder of the program
        environment["TMPDIR"] = scratch
        self.process = subprocess.Popen(
            [sys.executable, *PROGRAM, "--work", "--seed", str(seed), "--kinds", *kinds],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
            cwd=ROOT,
        )

    def answer(self, number: int) -> Outcome:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        timer = threading.Timer(_HANGS, self.process.kill)
        timer.start()
        try:
            print(number, file=self.process.stdin, flush=True)
            line = self.process.stdout.readline()
        finally:
            timer.cancel()
        if line:
            return Outcome(**json.loads(line))
        status = -self.process.wait()
        slow = status == getattr(signal, "SIGXCPU", 0)
        wrong = f"more than {MOST_SECONDS} s" if slow else f"ended by signal {status}"
        return Outcome(number, None, float(MOST_SECONDS), 0, wrong)

    def end(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()  # type: ignore[union-attr]


def run(
    numbers: Sequence[int],
    seed: int,
    kinds: Sequence[str] = tuple(KINDS),
    workers: int = 2,
    tell: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """The outcomes of cases, in their order."""
    left: queue.SimpleQueue[int] = queue.SimpleQueue()
    for number in numbers:
        left.put(number)
    found: list[Outcome] = []

    def work(scratch: str) -> None:
        worker = _Worker(seed, kinds, scratch)
        with contextlib.suppress(queue.Empty):
            while True:
                outcome = worker.answer(left.get_nowait())
                found.append(outcome)
                if tell:
                    tell(outcome)
                if outcome.status is None:  # its process may have ended, or be of no more use
                    worker.end()
                    worker = _Worker(seed, kinds, scratch)
        worker.end()

    with tempfile.TemporaryDirectory() as scratch:
        threads = [threading.Thread(target=work, args=(scratch,)) for _ in range(workers)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return sorted(found, key=lambda outcome: outcome.number)


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("cases", nargs="?", type=int, default=100, help="how many")
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    reader.add_argument("--only", type=int, help="the number of one case: its command line and files are printed too")
    reader.add_argument("--kinds", nargs="+", choices=tuple(KINDS), default=tuple(KINDS), help="left out, all")
    reader.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    options = reader.parse_args()
    if options.work:
        _work(options.seed, options.kinds)
        return 0
    numbers = range(options.cases) if options.only is None else [options.only]
    if options.only is not None:
        case = case_of(options.seed, options.only, options.kinds)
        print(
            case.arguments,
            *(f"--- {name}\n{text.decode('utf-8', 'backslashreplace')}" for name, text in case.files.items()),
            sep="\n",
        )

    def tell(outcome: Outcome) -> None:
        if outcome.wrong:
            case = case_of(options.seed, outcome.number, options.kinds)
            repeat = (
                f"python tests/fuzz.py --seed {options.seed} --only {outcome.number} --kinds {' '.join(options.kinds)}"
            )
            print(f"{repeat}: {case.kind}: {' '.join(map(repr, case.arguments))[:300]}")
            print("   ", outcome.wrong.replace("\n", "\n    "), flush=True)

    found = run(numbers, options.seed, options.kinds, options.workers, tell)
    slowest = max(found, key=lambda each: each.seconds)
    largest = max(found, key=lambda each: each.memory)
    statuses = {status: sum(each.status == status for each in found) for status in (*sorted(_STATUSES), None)}
    print(f"{len(found)} cases, {sum(bool(each.wrong) for each in found)} wrong; statuses {statuses}")
    print(f"slowest: {slowest.seconds:.1f} s (case {slowest.number})")
    print(f"most memory: {largest.memory / 1e6:.0f} MB (case {largest.number})")
    return int(any(each.wrong for each in found))


if __name__ == "__main__":
    sys.exit(main())
