"""Random cases of the command line: mutated scenarios and records.

    FUZZ_SEED=1 FUZZ_CASES=5000 python -m pytest -m slow tests/scenario/test_fuzz.py

A case must end with a documented status, without a traceback, a warning of Python or an internal error, within ten
seconds of processor time and 4 GiB of memory, must print JSON where it is asked to, and must leave what it reads as it
was. A case follows from its seed and number alone.
"""

import contextlib
import json
import os
import random
import re
import resource
import tempfile
import time
from collections.abc import Iterator
from functools import reduce
from multiprocessing import get_context
from operator import getitem
from pathlib import Path
from typing import Any

import pytest
import yaml
from pebble import ProcessPool

from shockwave.scenario.template import template
from support.command_line import shockwave
from support.scenario_texts import EVERY_FEATURE

ROOT = Path(__file__).parents[2]
#: Processor time that a case may take [s].
MOST_SECONDS = 10
#: Address space of the process of a case [bytes].
MOST_BYTES = 2**32
#: A case that waits for something for so long hangs [s]; a busy machine does not take so long.
HANGS = 300.0
STATUSES = (0, 1, 2, 3, 4, 5, 130)
WRONG = re.compile(r"Traceback \(most recent|internal error|[A-Z]\w+Warning:")

SCENARIOS = [file.read_bytes() for file in sorted((ROOT / "profiles").rglob("*.yaml"))]
HAMMER = (ROOT / "profiles" / "examples" / "hammer.csv").read_bytes()
RECORD = b"""\
chain: {material: copper, diameter: 9.5 mm}
shock:
  profile: tabulated
  parameters: {file: hammer.csv, baseline: [-60 us, -1 us], crop: [0 us, 160 us], negative: zero}
"""
#: Scenarios with many keys, from which others get single ones; they exclude each other.
MANY_KEYS = [EVERY_FEATURE, template(), template("tabulated")]
#: Values as they are typed.
NUMBERS = "0 -0.0 -1 1 1e-5 0.5 1e12 1e-320 1e308 1e999 -1e999 .nan .inf nan 1e5000 0x1F 1_000 1,5 +7"
#: Numbers that floating-point arithmetic does not take in all powers.
EXTREMES = ("1e-320", "1e-300", "1e-100", "1e-30", "1e-12", "0", "1e6", "1e12", "1e30", "1e100", "1e160", "1e300")
UNITS = ("s", "us", "N", "mm", "GPa", "kg/m**3", "", "%", "m/s", "furlong", "m**99", "/Hz", "degC")
TEXTS = (
    *("", " ", "true", "null", "[]", "{}", "[1, 2]", "{a: 1}", "*x", "&x 1", "!!python/object:os.system x", "<<"),
    *("[" * 3000, "{a: " * 3000, "{a: " * 300 + "}" * 300, "[" * 900 + "]" * 900),
    *("'", '"', "%", "@", "- ", "? ", ": ", "#", "|", "2001-01-01", "\u202e", "\u00e9", "\U0001f600", "\ufeff"),
    *("\0", "\t", "\r", "\x1b[31m", "\ud800", "a" * 5000, "[" * 200, "{a: " * 60, "9" * 5000, "../x", "/"),
    *("hammer.csv", "scene.yaml", "copper", "triangular", "tabulated", "section-4", "moments", "verlet", "5 %"),
    *("chain.radius", "chain.material", "shock.rise_time", "peak_force=60 N", "{linspace: [1, 2, 3]}"),
)
#: Commands on the file, as often as they are asked for.
COMMANDS = (
    *(4 * ["validate", "predict", "simulate --primary --rtol 1e-2"]),
    *(2 * ["predict --json", "simulate --json --primary --rtol 1e-2", "compare --primary --rtol 1e-2"]),
    *(2 * ["sweep --dry-run", "uncertainty --rtol 1e-2 --draws 64"]),
    *("curve --rtol 1e-2 --longest 1 -o out.json", "curve --rtol 1e-2 --longest 1 -o out.svg"),
    "design --vary chain.radius --target amplification=0.8 --between 1mm 5mm --rtol 1e-2 --points 3",
    "design --vary chain.material --target peak_force=60N --rtol 1e-2 --points 3",
    "bench --quick --longest 1e-3 --family quadratures",
)


#: A command, and the files in its folder.
Case = tuple[list[str], dict[str, bytes]]


def typed(rng: random.Random) -> str:
    """A value as it is typed."""
    if rng.random() < 0.4:
        return rng.choice(TEXTS)
    near = f"{rng.choice((1, -1)) * 10 ** rng.uniform(-8, 8):.4g}"
    return f"{rng.choice((near, rng.choice(NUMBERS.split())))} {rng.choice(UNITS)}".strip()


def paths(data: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of every value."""
    for key in list(data) if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ():
        yield (*above, key)
        yield from paths(data[key], (*above, key))


def graft(rng: random.Random, data: dict[str, Any]) -> None:
    """Give the scenario a value of another one, at the same path."""
    other = yaml.safe_load(rng.choice((*MANY_KEYS, *MANY_KEYS, *SCENARIOS)))
    *above, last = rng.choice(list(paths(other)))
    for step in above:
        other = other[step]
        if not isinstance(data.get(step), dict):
            data[step] = {}
        data = data[step]
    data[last] = other[last]


def extreme(rng: random.Random, old: Any) -> Any:
    """An extreme number in the place of ``old``, with its unit."""
    return re.sub(r"^[-+.\deE]+", rng.choice(EXTREMES), str(old)) if type(old) is str else float(rng.choice(EXTREMES))


def other_tree(rng: random.Random, text: bytes) -> bytes:
    """The scenario with keys deleted, added, or of other values."""
    data = yaml.safe_load(text)
    for _ in range(rng.choice((0, 0, 1, 1, 2, 3))):
        graft(rng, data)
    for _ in range(rng.choice((0, 1, 1, 2, 4))):
        *above, key = rng.choice(list(paths(data)) or [("a",)])
        holder = reduce(getitem, above, data)
        move, old = rng.random(), holder.get(key) if isinstance(holder, dict) else holder[key]
        if move < 0.2 and old is not None:
            del holder[key]
        elif move < 0.3 and isinstance(holder, dict):
            holder[typed(rng)] = old
        elif move < 0.5 and (type(old) in (int, float) or re.match(r"[-+.\d]", str(old))):
            holder[key] = extreme(rng, old)
        elif move < 0.6 and type(old) in (int, float):
            holder[key] = old * rng.choice((-1, 0, 1e-3, 0.5, 2, 1e9))
        else:
            holder[key] = rng.choice((None, True, -1, 1e308, 10**30, [typed(rng)], {typed(rng): [[]]}, typed(rng)))
    dumped = yaml.safe_dump(data, allow_unicode=True, default_flow_style=rng.choice((None, False)), sort_keys=False)
    # quotes come and go, so that text is read as numbers too
    return (dumped if rng.random() < 0.5 else dumped.replace("'", "")).encode("utf-8", "surrogatepass")


def other_text(rng: random.Random, text: bytes) -> bytes:
    """The text with bytes, lines or values changed, or its end missing."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(text) + 1)
        given = typed(rng).encode("utf-8", "surrogatepass")
        lines = text.splitlines(keepends=True)
        old: Any = rng.choice(list(re.finditer(rb"[\w.+-]+(?=[ ,}\n])", text)) or [re.match(b"", text)])
        moves = (
            text[:at],
            text[:at] + rng.choice((given, rng.randbytes(3))) + text[at:],
            text[: old.start()] + given + text[old.end() :],
            b"".join(rng.sample(lines, len(lines))),
            b"".join(line for line in lines if rng.random() < 0.8),
            text.replace(rng.choice((b"\n", b",")), rng.choice((b"\r", b"\r\n", b"\0", b"\x85", b";", b"\t"))),
            rng.choice((b"\xef\xbb\xbf", b"\xff\xfe", b"%YAML 9.9\n---\n", b"&a ")) + text,
            text * rng.choice((2, 50)),
        )
        text = rng.choice(moves)
    return text


def case_of(seed: str, number: int) -> Case:
    """The case of this number: a command on a mutated scenario, or on a mutated record."""
    rng = random.Random(f"{seed}-{number}")
    command = rng.choice(COMMANDS).split()
    if rng.random() < 0.3:
        return command, {"scene.yaml": RECORD, "hammer.csv": other_text(rng, HAMMER)}
    text = rng.choice((other_tree, other_text))(rng, rng.choice(SCENARIOS))
    return command, {"scene.yaml": text, "hammer.csv": HAMMER, "pulse.csv": HAMMER}


def problem_of(case: Case) -> str:
    """Run a case in the current process, in a folder of its own; what is wrong with it, or nothing."""
    command, files = case
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for name, content in files.items():
            Path(name).write_bytes(content)
        begin = time.process_time()
        answer = shockwave(*command, "scene.yaml")
        seconds = time.process_time() - begin
        changed = [name for name, content in files.items() if Path(name).read_bytes() != content]
    (answer.out + answer.err).encode()  # as for a terminal; raises if it cannot be shown
    if "--json" in command and answer.status == 0:
        try:
            json.loads(answer.out, parse_constant=lambda name: float(f"no number: {name}"))
        except ValueError as error:
            return f"no JSON: {error}: {answer.out[:200]}"
    elif WRONG.search(answer.out):
        return answer.out[-1500:]
    if answer.status not in STATUSES or WRONG.search(answer.err):
        return f"status {answer.status}: {answer.err[-1500:]}"
    return f"took {seconds:.1f} s, changed {changed}" if seconds > MOST_SECONDS or changed else ""


def limit_memory() -> None:
    """Limit the memory of this process."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))


def wrong_answers(seed: str, numbers: range, workers: int) -> dict[int, tuple[Case, str]]:
    """The cases that end in another way than documented, and how."""
    wrong = {}
    with ProcessPool(workers, initializer=limit_memory, context=get_context("spawn")) as pool:
        cases = {number: case_of(seed, number) for number in numbers}
        futures = {number: pool.schedule(problem_of, (case,), timeout=HANGS) for number, case in cases.items()}
        for number, future in futures.items():
            try:
                problem = future.result()
            except Exception as error:  # the process ended, or hangs
                problem = f"{type(error).__name__}: {error}"
            if problem:
                wrong[number] = (cases[number], problem)
    return wrong


@pytest.mark.parametrize(
    ("seed", "count"),
    [
        ("default", 30),
        pytest.param(
            os.environ.get("FUZZ_SEED", "0"), int(os.environ.get("FUZZ_CASES", "100")), marks=pytest.mark.slow
        ),
    ],
    ids=["some", "chosen"],
)
def test_random_cases_end_as_documented(seed: str, count: int) -> None:
    assert wrong_answers(seed, range(count), workers=1 + count // 50) == {}
