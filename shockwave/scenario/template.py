"""Templates: a scenario to begin with, every key with its meaning."""

from __future__ import annotations

import json
import re
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

from shockwave.chain.material import Material
from shockwave.fields import Quantity
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.registry import find
from shockwave.scenario.blocks import (
    CHAIN,
    RECORD,
    UNSTATED,
    Key,
    Published,
    keys_of,
    parameters_of,
    profile_class,
    shock_keys,
)

__all__ = ["template"]

_DEFAULT = "power-law"
_HEAD = """\
# One shock on one chain of equal elastic spheres.
# A bare number is in SI units; text is a number with a unit of the same dimension, such as 15 us.
# Lines behind a # may be left out; where they show a value that is not the default, it is an example.
"""
_EXAMPLES = {
    "youngs_modulus": "193 GPa",
    "poisson_ratio": "0.3",
    "density": "7958 kg/m**3",
    "diameter": "9.5 mm",
    "radius": "4.75 mm",
    "granules": "200",
    "peak_force": "100 N",
    "rise_time": "15 us",
    "duration_ratio": "10",
    "quadrature": "tanh-sinh",
    "rtol": "1e-6",
    "integrator": "rkn1210",
    "step": "0.02",
    "interval": "1 us",
    "until": "2 ms",
    "source": "the paper, Table 1",
    "virtual_rise_time": "28 us",
    "error": "3 %",
}
_MEANINGS = {
    "name": "what it is called",
    "source": "where the figures come from",
    "radius": "in place of the diameter",
    "granules": "left out, the chain is as long as the answer needs",
    "model": "a name that `shockwave list models` shows",
    "rtol": "for models with a tolerance; section-4 has none and refuses it",
    "momentum_coefficient": "leading number of A, eq. (4c): exact (4.3445...), paper (13/3) or 0.01 to 1000",
    "alpha": "constant (of section 4.1) or literal (eq. (5c) as printed)",
    "quadrature": "for all integrals, even those with closed forms; see `shockwave list quadratures`",
    "integrator": "see `shockwave list integrators`; left out, rkn86, or rkn1210 where rtol is below 1e-7",
    "waves": "train, or primary for the first wave alone",
    "backend": "auto, compiled or numpy; see `shockwave list backends`",
    "contacts": "where the passage of the primary is wanted, counted from 0",
    "record": "histories to keep: forces (at the contacts), field, energies",
    "relation": "of the primary's peak to the shock's: less, equal or greater",
}
_RECORD_EXAMPLES = {"file": "pulse.csv", "times": "[0 s, 15 us, 150 us]", "forces": "[0 N, 100 N, 0 N]"}
_OWN = "shockwave"
_OWN = "shockwave"
_PLAIN = re.compile(r"(?!(?:true|false|null)\Z)[a-z][a-z0-9-]*")


def template(profile: str | None = None) -> str:
    """The text of a scenario with every key, its meaning, and a value to begin with.

    Parameters
    ----------
    profile : str, optional
        Name of a registered profile, of a plugin too. Left out: ``power-law``.

    Raises
    ------
    UnknownNameError
        When no profile has the name.
    PluginError
        When the plugin that has it is at fault.
    """
    name = profile or _DEFAULT
    cls = profile_class(name)
    owner = find("profiles", name).distribution
    blocks = (
        [f"name: {_text(name)}  # what the scenario is called; left out, the name of the file"],
        ["chain:", *_chain()],
        ["shock:", *_shock(name, cls)],
        ["predict:", *_lines(keys_of(Predictor))],
        ["simulate:", *_lines(keys_of(SimulateOptions))],
        [_requires(owner)],
        ["# published:  # figures printed in a source, shown beside ours", *_published()],
    )
    return "\n".join([_HEAD, *("\n".join(block) + "\n" for block in blocks)])


def _chain() -> Iterator[str]:
    yield "  material: paper-steel  # a name that `shockwave list materials` shows, or a mapping:"
    yield "  # material:"
    yield from _lines(keys_of(Material), "  #   ", behind="  #   ")
    diameter, *others = (key for key in CHAIN if key.name != "material")
    yield _line("  ", diameter, _EXAMPLES[diameter.name])
    for key in others:
        yield _line("  # ", key, _EXAMPLES[key.name])


def _shock(name: str, cls: Any) -> Iterator[str]:
    yield f"  profile: {_text(name)}  # a name that `shockwave list profiles` shows"
    has_ratio = any(key.name == "duration_ratio" for key in keys_of(cls))
    for key in shock_keys(cls):
        if key.name in ("peak_force", "rise_time") or (key.name == "duration_ratio" and has_ratio):
            usual = key.spec is None or key.spec.problem(10) is None
            yield _line("  " if key.required else "  # ", key, _example(key, _EXAMPLES if usual else {}))
    parameters = parameters_of(name, cls)
    if not parameters:
        return
    lines = list(_parameters(name, parameters))
    live = any(not line.lstrip().startswith("#") for line in lines)
    yield "  parameters:" if live else "  # parameters:"
    yield from lines


def _parameters(name: str, keys: Sequence[Key]) -> Iterator[str]:
    if name != RECORD:
        yield from _lines(keys, "    ", behind="    # ", examples={})
        return
    for key in keys:
        yield _line("    # " if key.name == "file" else "    ", key, _RECORD_EXAMPLES[key.name])


def _published() -> Iterator[str]:
    yield from _lines(keys_of(Published), "#   ", behind="#   ")


def _requires(owner: str) -> str:
    meaning = "distributions that must be installed for this scenario"
    return f"{'# ' if owner == _OWN else ''}requires: [{_text(owner)}]  # {meaning}"


def _lines(
    keys: Sequence[Key],
    indent: str = "  ",
    behind: str = "  # ",
    examples: Mapping[str, str] = _EXAMPLES,
) -> Iterator[str]:
    """A line for each key; those without a value of their own stand ``behind`` a mark."""
    for key in keys:
        live = key.required or _default(key) is not None
        yield _line(indent if live else behind, key, _example(key, examples))


def _line(indent: str, key: Key, value: str) -> str:
    meaning = _MEANINGS.get(key.name) if key.spec is None else None
    purpose = "; ".join(part for part in (key.purpose, meaning) if part)
    if key.spec is not None and key.name in ("radius", "granules"):
        purpose = f"{purpose}; {_MEANINGS[key.name]}"
    comment = " ".join(purpose.split())
    return f"{indent}{key.name}: {value}" + (f"  # {comment}" if comment else "")


def _example(key: Key, examples: Mapping[str, str] = _EXAMPLES) -> str:
    """A value that ``key`` takes, as YAML: its default, an example, or else any."""
    default = _default(key)
    if default is not None:
        return default
    if key.name in examples:
        return examples[key.name]
    if key.spec is None:
        return _text(_of_kind(key.annotation))
    return "[0, 1, 2]" if key.spec.samples else _text(_within(key.spec))


def _default(key: Key) -> str | None:
    """The default of ``key`` in YAML, if it has one that can be written."""
    if key.default is None or key.default is UNSTATED:
        return None
    try:
        return _text(key.default)
    except (TypeError, ValueError):
        return None


def _of_kind(annotation: Any) -> Any:
    """A value of an annotated type."""
    origin, members = typing.get_origin(annotation) or annotation, typing.get_args(annotation)
    if origin is Literal:
        return members[0]
    if origin in (list, tuple, dict):
        return {} if origin is dict else []
    simple: dict[Any, Any] = {bool: False, int: 1, float: 1.0, str: "text"}
    if typing.get_args(next(iter(members), None)):  # an optional type, such as Literal[...] | None
        return _of_kind(members[0])
    return next((simple[kind] for kind in (origin, *members) if kind in simple), 1)


def _within(spec: Quantity) -> float:
    """A number inside the range of ``spec``, a simple one where there is one."""
    low = next((bound for bound in (spec.above, spec.at_least) if bound is not None), None)
    high = next((bound for bound in (spec.below, spec.at_most) if bound is not None), None)
    tried: list[float] = [1, 2, 10, 0.5, 0, -1]
    if low is not None and high is not None:
        tried += [round((low + high) / 2), (low + high) / 2]
    tried += [move for low in (low,) if low is not None for move in (low + 1, 2 * low, low / 2, low)]
    tried += [move for high in (high,) if high is not None for move in (high - 1, high / 2, 2 * high, high)]
    return next((number for number in tried if spec.problem(number) is None), 1)


def _text(value: Any) -> str:
    """``value`` in YAML, of which JSON is a part; names need no quotes."""
    if isinstance(value, str) and _PLAIN.fullmatch(value):
        return value
    if isinstance(value, float) and abs(value) < 1e6 and value == int(value):
        return str(int(value))
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
