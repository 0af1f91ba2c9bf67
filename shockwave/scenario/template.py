"""Templates: a scenario to begin with, every key with its meaning."""

from __future__ import annotations

import json
import re
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, Literal

from shockwave import OWN_DISTRIBUTION
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
from shockwave.scenario.sweep import SWEEP
from shockwave.scenario.uncertainty import FORMS
from shockwave.scenario.units import to_si

__all__ = ["purpose_of", "template", "within"]

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
    "duration": "150 us",
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
    "parameters": "what the profile takes besides",
    "predict": "how the waves are to be predicted",
    "simulate": "how the scene is to be simulated",
    "published": "figures printed in a source, shown beside ours",
    "sweep": "many scenes in one file, for `shockwave sweep`",
    "uncertainty": "how well values are known, for `shockwave uncertainty`; 5 % is a relative standard deviation",
    "name": "what it is called",
    "source": "where the figures come from",
    "radius": "in place of the diameter",
    "granules": "left out, the chain is as long as the answer needs",
    "model": "a name that `shockwave list models` shows",
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
_SWEPT = {
    "run": "simulate",
    "grid": "{shock.rise_time: {linspace: [5 us, 50 us, 10]}, chain.diameter: [5 mm, 10 mm]}",
    "zip": "{chain.material: [paper-steel, brass-260], chain.granules: [200, 400]}",
    "points": "[{shock.peak_force: 50 N}, {shock.peak_force: 100 N}]",
}
#: Quantities of which more is to be said than their declaration does.
_TOLD_TOO = ("radius", "granules")
_RECORD_EXAMPLES = {"file": "pulse.csv", "times": "[0 s, 15 us, 150 us]", "forces": "[0 N, 100 N, 0 N]"}
_PLAIN = re.compile(r"(?!(?i:true|false|null)\Z)[A-Za-z_][A-Za-z0-9_-]*")
#: Kind of a parameter that is no quantity -> how it is called, and one of its values.
_KINDS: Final[dict[Any, tuple[str, Any]]] = {
    bool: ("true or false", False),
    int: ("a whole number", 1),
    float: ("a number", 1.0),
    str: ("text", "text"),
}
#: Sizes that are met in chains of spheres, where nothing else is told.
_BY_UNIT = {
    "s": ("10 us", "1 ms", "1 s"),
    "m": ("5 mm", "1 m"),
    "N": ("100 N",),
    "kg": ("1 g", "1 kg"),
    "Pa": ("200 GPa", "1 MPa"),
    "m/s": ("1 m/s",),
}
_ARRAYS, _UNIONS = (list, tuple, Sequence), (typing.Union, types.UnionType)


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
        [f"# published:  # {_MEANINGS['published']}", *_published()],
        [f"# sweep:  # {_MEANINGS['sweep']}", *(f"#   {k.name}: {_SWEPT[k.name]}  # {k.meaning}" for k in SWEEP)],
        [f"# uncertainty:  # {_MEANINGS['uncertainty']}", *_uncertainty()],
    )
    return "\n".join([_HEAD, *("\n".join(block) + "\n" for block in blocks)])


def _uncertainty() -> Iterator[str]:
    yield "#   shock.peak_force: 5 %"
    shown = {"sd": ("shock.rise_time", "1 us"), "between": ("chain.diameter", "[9 mm, 10 mm]")}
    shown["factor"] = ("chain.material.youngs_modulus", "1.1")
    for form, (name, value) in shown.items():
        yield f"#   {name}: {{{form}: {value}}}  # {FORMS[form]}"


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
    # One that can bring its own force and time, but does not as it stands here.
    bare = not any(key.required for key in (*shock_keys(cls)[1:], *keys_of(cls)))
    brings_none = bare and cls().recorded_rise_time is None
    for key in shock_keys(cls):
        if key.name not in ("profile", "parameters") and (key.name != "duration_ratio" or has_ratio):
            usual = key.spec is None or key.spec.problem(10) is None
            live = key.required or (key.name in ("peak_force", "rise_time") and brings_none)
            yield _line("  " if live else "  # ", key, _example(key, _EXAMPLES if usual else {}))
    parameters = parameters_of(name, cls)
    if not parameters:
        return
    lines = list(_parameters(name, parameters))
    live = any(not line.lstrip().startswith("#") for line in lines)
    yield "  parameters:" if live else "  # parameters:"
    yield from lines


def _parameters(name: str, keys: Sequence[Key]) -> Iterator[str]:
    if name != RECORD:
        yield from _lines(keys, "    ", behind="    # ", own=False)
        return
    for key in keys:
        yield _line("    # " if key.name == "file" else "    ", key, _RECORD_EXAMPLES[key.name], own=False)


def _published() -> Iterator[str]:
    yield from _lines(keys_of(Published), "#   ", behind="#   ")


def _requires(owner: str) -> str:
    meaning = "distributions that must be installed for this scenario"
    return f"{'# ' if owner == OWN_DISTRIBUTION else ''}requires: [{_text(owner)}]  # {meaning}"


def _lines(keys: Sequence[Key], indent: str = "  ", behind: str = "  # ", own: bool = True) -> Iterator[str]:
    """A line for each key; those without a value of their own stand ``behind`` a mark.

    Keys that are not shockwave's ``own``, but a profile's, have neither its examples nor its meanings.
    """
    for key in keys:
        live = key.required or _default(key) is not None
        yield _line(indent if live else behind, key, _example(key, _EXAMPLES if own else {}), own)


def _line(indent: str, key: Key, value: str, own: bool = True) -> str:
    comment = " ".join(purpose_of(key, own).split())
    return f"{indent}{_text(key.name)}: {value}" + (f"  # {comment}" if comment else "")


def purpose_of(key: Key, own: bool = True) -> str:
    """What a key is for, in words: meaning, unit and range, and what else there is to know.

    Where nothing is declared, its kind. ``own`` is False for parameters of profiles.
    """
    spec = key.spec
    if spec is not None and spec.samples:
        bounds = (spec.above, spec.at_least, spec.below, spec.at_most)
        bounded = any(bound is not None for bound in bounds)
        return f"{spec.meaning}, each {spec.rule}" if bounded else f"{spec.meaning}, {spec.unit}".rstrip(", ")
    told = own and (not key.purpose or key.name in _TOLD_TOO)
    more = _MEANINGS.get(key.name, "") if told else ""
    return "; ".join(part for part in (key.purpose, more) if part) or _called(key.annotation)


def _example(key: Key, examples: Mapping[str, str] = _EXAMPLES) -> str:
    """A value that ``key`` takes, as YAML: its default, an example, or else any."""
    default = _default(key)
    if default is not None:
        return default
    if key.name in examples:
        return examples[key.name]
    if key.spec is None:
        value = _of_kind(key.annotation)
        return _text(1 if value is None and key.required else value)
    if key.spec.example:
        return key.spec.example
    if not key.spec.samples:
        usual = (
            text for text in _BY_UNIT.get(key.spec.unit, ()) if key.spec.problem(to_si(text, key.spec.unit)) is None
        )
        return next(usual, _text(within(key.spec)))
    fit = [number for number in (0, 1, 2, 3, 4) if key.spec.problem(number) is None]
    return _text(fit[:3] or [within(key.spec)])


def _default(key: Key) -> str | None:
    """The default of ``key`` in YAML, if it has one that can be written."""
    if key.default is None or key.default is UNSTATED:
        return None
    try:
        return _text(key.default)
    except (TypeError, ValueError):
        return None


def _called(annotation: Any) -> str:
    """The kind of an annotated value, in words; nothing for one that a document has no word for."""
    origin, members = typing.get_origin(annotation) or annotation, typing.get_args(annotation)
    if origin is Literal:
        return f"one of {', '.join(map(str, members))}"
    if origin in _ARRAYS:
        item = _called(members[0]) if members else ""
        return f"a list, each {item}" if item else "a list"
    if origin in _KINDS:
        return _KINDS[origin][0]
    kinds = [_called(member) for member in members] if origin in _UNIONS else []
    return " or ".join(dict.fromkeys(kind for kind in kinds if kind))


def _of_kind(annotation: Any) -> Any:
    """A value of an annotated type; None where none is known."""
    origin, members = typing.get_origin(annotation) or annotation, typing.get_args(annotation)
    if origin is Literal:
        return members[0]
    if origin in _ARRAYS or origin is dict:
        return {} if origin is dict else []
    if origin in _KINDS:
        return _KINDS[origin][1]
    values = [_of_kind(member) for member in members] if origin in _UNIONS else []
    return next((value for value in values if value is not None), None)


def within(spec: Quantity) -> float:
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
