"""Random cases for the command line, each made from a seed and its number alone; see fuzz.py."""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from attrs import frozen

__all__ = ["KINDS", "Case", "case_of", "command_case", "commands"]

ROOT = Path(__file__).parent.parent


@frozen
class Case:
    """A command line, and the files that lie in its folder."""

    kind: str
    arguments: tuple[str, ...]
    files: dict[str, bytes]


# ---------------------------------------------------------------- material


@cache
def scenarios() -> tuple[bytes, ...]:
    """The scenarios that come along, and those of the pages."""
    found = [file.read_bytes() for file in sorted((ROOT / "profiles").rglob("*.yaml"))]
    for page in sorted((ROOT / "docs").glob("*.md")):
        blocks = re.findall(r"^```yaml\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        found += [block.encode() for block in blocks]
    return tuple(found)


@cache
def _hammer() -> bytes:
    return (ROOT / "profiles" / "examples" / "hammer.csv").read_bytes()


_SMALL = b"""\
name: small
chain: {material: copper, diameter: 9.5 mm}
shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}
"""
_RECORD = b"""\
chain: {material: copper, diameter: 9.5 mm}
shock: {profile: tabulated, parameters: {file: hammer.csv}}
"""
_NUMBERS = (
    *("0", "-0.0", "-1", "1", "2", "3", "1e-5", "0.5", "1e3", "1e12", "1e-12", "1e-300", "1e-320", "1e308", "1e999"),
    *("-1e999", ".nan", ".inf", "nan", "inf", "1e5000", "9" * 5000, "1e-9999", "0x1F", "0o17", "1_000", "1,5", "+7"),
    *("1" + "0" * 400, "1e-30", "1e30", "12345678901234567890"),
)
_TEXTS = (
    *("", " ", "x", "true", "null", "~", "[]", "{}", "[1, 2]", "{a: 1}", "*x", "&x 1", "!!python/object:os.system x"),
    *("'", '"', "%", "@", "`", "- ", "? ", ": ", "#", "|", ">", "<<", "2001-01-01", "12:30:45", "\u202e", "\u00e9"),
    *("\U0001f600", "\ufeff", "\0", "\t", "\r", "\x1b[31m", "\ud800", "a" * 5000, "[" * 200, "{a: " * 60, "../x", "/"),
    *("hammer.csv", "scene.yaml", "nowhere.csv", "copper", "steel", "triangular", "tabulated", "power-law", "auto"),
    *("section-4", "moments", "exact", "paper", "literal", "compiled", "numpy", "rkn86", "verlet", "radau", "dop853"),
    *("chain.radius", "chain.material", "shock.peak_force", "shock.rise_time", "shock.parameters.rise_exponent"),
    *("peak_force=60 N", "amplification=0.8", "peak_force", "=", "a=b=c", "{linspace: [1, 2, 3]}", "5 %", "-3 %"),
    *("10 us", "15 furlong", "1 m**99", "9**9**9 m", "1 kg", "100 N", "2 mm", "5 degC", "1 /Hz", "1e400 N", "5 mm mm"),
)
_UNITS = ("s", "us", "N", "mm", "GPa", "kg/m**3", "", "%", "m/s", "K")


def _text(rng: random.Random) -> str:
    """A value as it is typed."""
    move = rng.random()
    if move < 0.4:
        return rng.choice(_TEXTS)
    number = rng.choice(_NUMBERS) if move < 0.7 else f"{rng.choice((1, -1)) * 10 ** rng.uniform(-8, 8):.4g}"
    return f"{number} {rng.choice(_UNITS)}".strip() if rng.random() < 0.4 else number


def _value(rng: random.Random, depth: int = 0) -> Any:
    """A value as YAML may hold it."""
    move = rng.random()
    if depth < 3 and move < 0.12:
        return [_value(rng, depth + 1) for _ in range(rng.randrange(4))]
    if depth < 3 and move < 0.24:
        return {_text(rng): _value(rng, depth + 1) for _ in range(rng.randrange(4))}
    if move < 0.3:
        value: Any = 0
        for _ in range(rng.choice((5, 40, 400))):
            value = [value] if rng.random() < 0.5 else {"a": value}
        return value
    if move < 0.45:
        return rng.choice((None, True, False, 0, -1, 1e308, -1e-308, 10**30, 0.5, 3))
    return _text(rng)


# ---------------------------------------------------------------- mutations


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    """Every container with each of its keys or indices."""
    for key in list(data) if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ():
        yield data, key
        yield from _places(data[key])


def _mutated_tree(rng: random.Random, text: bytes) -> bytes:
    """The scenario with keys deleted, added, doubled or of other values."""
    data = yaml.safe_load(text)
    for _ in range(rng.choice((1, 1, 2, 4))):
        places = list(_places(data))
        if not places:
            return text
        holder, key = rng.choice(places)
        move = rng.random()
        if move < 0.2:
            del holder[key]
        elif move < 0.3 and isinstance(holder, dict):
            holder[_text(rng)] = holder[key]
        elif move < 0.4 and isinstance(holder, dict):
            other, twin = rng.choice(places)
            holder[key] = other[twin] if not isinstance(other[twin], dict | list) else None
        elif move < 0.6 and isinstance(holder[key], int | float) and not isinstance(holder[key], bool):
            holder[key] = holder[key] * rng.choice((-1, 0, 1e-3, 0.5, 2, 1e3, 1e9, 1e-9))
        else:
            holder[key] = _value(rng)
    with contextlib.suppress(RecursionError):
        # quotes come and go, so that text is read as numbers too
        dumped = yaml.safe_dump(data, allow_unicode=True, default_flow_style=rng.choice((None, False)), sort_keys=False)
        return (dumped if rng.random() < 0.5 else dumped.replace("'", "")).encode("utf-8", "surrogatepass")
    return text


def _mutated_text(rng: random.Random, text: bytes) -> bytes:
    """The text with lines or bytes changed, or its end missing."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        text = _changed(rng, text)
    return text


def _changed(rng: random.Random, text: bytes) -> bytes:
    lines, at = text.split(b"\n"), rng.randrange(len(text) + 1)
    line, given = rng.randrange(len(lines)), _text(rng).encode("utf-8", "surrogatepass")
    indent = rng.choice((b" ", b"  ", b"\t"))
    moves: tuple[Callable[[], bytes], ...] = (
        lambda: text[:at],
        lambda: text[:at] + given + text[at:],
        lambda: text[:at] + rng.randbytes(rng.choice((1, 3, 200))) + text[at + 1 :],
        lambda: text[: max(at - 3, 0)] + text[at:],
        lambda: b"\n".join(lines[:line] + lines[line + 1 :]),
        lambda: b"\n".join(lines[: line + 1] + lines[line:]),
        lambda: b"\n".join([*lines[:line], indent + lines[line], *lines[line + 1 :]]),
        lambda: re.sub(rb"(?<=: )[\w.+-]+", lambda found: given if rng.random() < 0.2 else found[0], text),
        lambda: text.replace(b"\n", rng.choice((b"\r", b"\r\n", b"\0", b"\n\n", b"\x85"))),
        lambda: rng.choice((b"\xef\xbb\xbf", b"\xff\xfe", b"%YAML 9.9\n---\n", b"---\n", b"&a ", b"\x1f\x8b")) + text,
        lambda: text * rng.choice((2, 50)),
    )
    return rng.choice(moves)()


def _rescaled(rng: random.Random, text: bytes) -> bytes:
    """The text with some of its numbers a little or far larger or smaller, so that most scenes remain valid."""

    def changed(found: re.Match[bytes]) -> bytes:
        if rng.random() < 0.7:
            return found[0]
        return b"%.4g" % (float(found[0]) * rng.choice((0.5, 0.9, 1.1, 2, 10 ** rng.uniform(-3, 3))))

    return re.sub(rb"(?<=[ \[])[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]+)?(?=[ ,\]}\n])", changed, text)


def _mutated(rng: random.Random, text: bytes) -> bytes:
    return rng.choices((_mutated_tree, _mutated_text, _rescaled), (4, 3, 3))[0](rng, text)


def _mutated_record(rng: random.Random) -> bytes:
    """A record with cells, rows or separators changed, or no record at all."""
    if rng.random() < 0.3:
        count = rng.choice((0, 1, 2, 3, 5, 50))
        rows = [(rng.uniform(-1, 1) * 10 ** rng.uniform(-9, 3), rng.gauss(0, 100)) for _ in range(count)]
        if rng.random() < 0.7:
            rows.sort()
        text = "".join(f"{a:.6g},{b:.6g}\n" for a, b in rows).encode()
    else:
        text = _hammer()
    move = rng.random()
    if move < 0.5:
        rows_ = [line.split(b",") for line in text.split(b"\n")]
        for _ in range(rng.choice((1, 2, 10))):
            row = rng.choice(rows_)
            cell = _text(rng).encode("utf-8", "surrogatepass")
            row[rng.randrange(len(row))] = cell
            if rng.random() < 0.2:
                row.append(cell)
        return b"\n".join(b",".join(row) for row in rows_)
    if move < 0.7:
        return text.replace(b",", rng.choice((b";", b"\t", b" ", b", ,", b"|", b""))).replace(
            b".", rng.choice((b".", b","))
        )
    if move < 0.75:
        return rng.choice((b"", b"\n", b"\0" * 1000, b"1,2", b"," * 20_000, b"0,0\n" * 1000, rng.randbytes(2000)))
    return _mutated_text(rng, text)


# ---------------------------------------------------------------- kinds of cases

#: Options that keep a command cheap, and are always given.
_CHEAP = {
    "simulate": ("--primary", "--rtol", "1e-2"),
    "compare": ("--primary", "--rtol", "1e-2"),
    "curve": ("--rtol", "1e-2", "--longest", "1"),
    "design": ("--rtol", "1e-2", "--points", "3"),
    "uncertainty": ("--rtol", "1e-2", "--draws", "64"),
    "bench": ("--quick", "--longest", "1e-3", "--family", "quadratures"),
    "sweep": ("--dry-run",),
}
_OF_SCENES = ("validate", "predict", "simulate", "compare")
_WEIGHTS = (4, 5, 3, 1)


def _on_scene(rng: random.Random, file: str) -> tuple[str, ...]:
    """A command on a scenario."""
    move = rng.random()
    if move < 0.75:
        command = rng.choices(_OF_SCENES, _WEIGHTS)[0]
        json_ = ("--json",) if rng.random() < 0.3 else ()
        return (command, file, *_CHEAP.get(command, ()), *json_)
    if move < 0.8:
        return ("curve", file, *_CHEAP["curve"], *rng.choice(((), ("-o", "out.json"), ("-o", "out.svg"))))
    if move < 0.86:
        vary = rng.choice(("chain.radius", "chain.diameter", "shock.rise_time", "shock.peak_force", "chain.material"))
        between = (
            ()
            if vary == "chain.material"
            else ("--between", *rng.choice((("1", "2"), ("1 mm", "5 mm"), ("1 us", "9 us"))))
        )
        target = rng.choice(("amplification=0.8", "peak_force=60 N", "momentum=1e-3", "speed=500 m/s"))
        return ("design", file, *_CHEAP["design"], "--vary", vary, "--target", target, *between)
    if move < 0.91:
        return ("uncertainty", file, *_CHEAP["uncertainty"])
    if move < 0.98:
        return ("sweep", file, "--dry-run")
    if move < 0.985:
        return ("report", file, "-o", "out.html")
    return ("bench", file, *_CHEAP["bench"])


def scenario_case(rng: random.Random) -> Case:
    """A command on a mutated scenario."""
    text = _mutated(rng, rng.choice(scenarios()))
    return Case(
        "scenario", _on_scene(rng, "scene.yaml"), {"scene.yaml": text, "hammer.csv": _hammer(), "pulse.csv": _hammer()}
    )


def record_case(rng: random.Random) -> Case:
    """A command on a mutated record."""
    return Case("record", _on_scene(rng, "scene.yaml"), {"scene.yaml": _RECORD, "hammer.csv": _mutated_record(rng)})


@cache
def commands() -> dict[str, list[argparse.Action]]:
    from shockwave.cli.parser import parser

    (subparsers,) = (action for action in parser()._actions if isinstance(action, argparse._SubParsersAction))
    return {name: command._actions for name, command in subparsers.choices.items()}


_GOOD = (
    "scene.yaml",
    "record.yaml",
    "swept.yaml",
    "uncertain.yaml",
    "hammer.csv",
    "nowhere.yaml",
    ".",
    "*.yaml",
    "*.x",
)
_OUTPUTS = (
    "out.html",
    "out.svg",
    "out.json",
    "out.png",
    "out.pdf",
    "scene.yaml",
    "hammer.csv",
    ".",
    "",
    "no/out.svg",
    "a\0",
)
_SWEPT = _SMALL + b"sweep: {grid: {shock.duration_ratio: [2, 4]}}\n"
_UNCERTAIN = _SMALL + b"uncertainty: {shock.peak_force: 3 %}\n"


def _argument(rng: random.Random, action: argparse.Action) -> str:
    if action.dest in ("output", "out"):
        return rng.choice(_OUTPUTS)
    if action.dest in ("file", "files", "folder"):
        return rng.choice(_GOOD)
    if action.choices and rng.random() < 0.8:
        return str(rng.choice(list(action.choices)))
    return _text(rng)


def command_case(rng: random.Random) -> Case:
    """A command line of random options; what makes a command cheap comes last, and so counts."""
    name = rng.choice(list(commands()))
    arguments = [name]
    for action in commands()[name]:
        count = (
            action.nargs
            if isinstance(action.nargs, int)
            else rng.choice((1, 1, 2))
            if action.nargs in ("+", "*")
            else 1
        )
        if not action.option_strings:
            if action.required or rng.random() < 0.5:
                arguments += [_argument(rng, action) for _ in range(count)]
        elif action.required or rng.random() < 0.35:
            arguments += [rng.choice(action.option_strings), *(_argument(rng, action) for _ in range(count))]
    if name == "stress":  # the catalogue takes minutes
        arguments[1:2] = arguments[1:2] or ["nothing"]
    if name == "report" and rng.random() < 0.8:  # a page takes long
        arguments[0] = name = "validate"
    for _ in range(rng.choice((0, 0, 0, 1))):
        arguments.insert(
            rng.randrange(len(arguments) + 1), rng.choice((_text(rng), "--no-plugins", "--help", "--", "-x"))
        )
    files = {"scene.yaml": _SMALL, "record.yaml": _RECORD, "swept.yaml": _SWEPT, "uncertain.yaml": _UNCERTAIN}
    return Case("command", (*arguments, *_CHEAP.get(name, ())), {**files, "hammer.csv": _hammer()})


@cache
def _results() -> dict[str, bytes]:
    """The files of a small sweep."""
    from shockwave.sweep.runner import run_sweep

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "swept.yaml").write_bytes(_SWEPT)
        run_sweep(Path(folder) / "swept.yaml", Path(folder) / "results", workers=1)
        files = (file for file in sorted(Path(folder).rglob("*")) if file.is_file())
        return {file.relative_to(folder).as_posix(): file.read_bytes() for file in files}


def result_case(rng: random.Random) -> Case:
    """A command on a folder of results, some of which are mutated or missing."""
    files = dict(_results())
    for name in rng.sample(sorted(files), rng.choice((1, 1, 2))):
        if rng.random() < 0.15:
            del files[name]
        elif name.endswith(".json") and rng.random() < 0.5:
            data = json.loads(files[name])
            holder, key = rng.choice(list(_places(data)))
            holder[key] = _value(rng)
            files[name] = json.dumps(data).encode("utf-8", "surrogatepass")
        else:
            files[name] = _mutated_text(rng, files[name])
    picture = rng.choice(((), ("-o", "out.svg"), ("--at", "shock.duration_ratio=2"), ("--column", "regime")))
    again = ("sweep", "swept.yaml", "-o", "results", *_CHEAP["sweep"])
    return Case("result", rng.choice((("plot", "results", *picture), again)), files)


#: Kinds of cases: what makes one -> how often it is asked.
KINDS: dict[str, tuple[Callable[[random.Random], Case], int]] = {
    "scenario": (scenario_case, 45),
    "record": (record_case, 20),
    "command": (command_case, 30),
    "result": (result_case, 5),
}


def case_of(seed: int, number: int, kinds: Sequence[str] = tuple(KINDS)) -> Case:
    """The case of this number."""
    rng = random.Random(f"{seed}-{number}")
    made, weights = zip(*(KINDS[kind] for kind in kinds), strict=True)
    case: Case = rng.choices(made, weights)[0](rng)
    return case
