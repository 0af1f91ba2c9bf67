"""The catalogue of extreme cases as records, read from ``extreme_cases.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from importlib import resources
from typing import Any

from attrs import Factory, field, frozen

from shockwave.errors import UnknownNameError


@frozen(kw_only=True)
class Case:
    """One extreme.

    Attributes
    ----------
    name, theme : str
        Its name, and the part of the catalogue in which it stands.
    asked, must : str
        What is asked, and what must happen.
    check : str
        The function of `extreme_checks` that judges the answer.
    scene, other : dict
        A function of `extreme_scenes` with its arguments; ``other`` is a scene to compare with.
    options : dict
        Arguments of the simulation.
    reference, bound : float
        An amplification to compare with, and how far the answer may be from the reference, relatively. The default is
        twice the default tolerance: once for the run, once for its reference.
    error, message : str
        The class of the error that must be raised, and a part of its message.
    limit : float
        Time after which it counts as hung [s]; cases with more than the default take seconds.
    """

    name: str
    theme: str
    asked: str
    check: str
    scene: dict[str, Any]
    other: dict[str, Any] = Factory(dict)
    options: dict[str, Any] = Factory(dict)
    reference: float = 0.0
    bound: float = 2e-6
    error: str = "InvalidValueError"
    message: str = ""
    must: str = field()
    limit: float = 60.0

    @must.default
    def _refusal(self) -> str:
        return f"{self.error}: '{self.message}'"

    @property
    def each_backend(self) -> bool:
        """Whether another backend makes it another case: not where nothing is stepped, or by NumPy alone."""
        return self.check != "refused" and "backend" not in self.options


def _read() -> tuple[Case, ...]:
    document = tomllib.loads(resources.files(__package__).joinpath("extreme_cases.toml").read_text("utf-8"))
    cases = []
    for theme, entries in document["themes"].items():
        for entry in entries:
            common = document["common"].get(entry["check"], {})
            cases.append(Case(theme=theme, **{**common, **entry}))
    return tuple(cases)


#: Every case, theme by theme.
CASES = _read()


def find(names: Iterable[str]) -> tuple[Case, ...]:
    """The cases of these names, or of the themes among them, in the order of the catalogue; all for no name.

    Raises
    ------
    UnknownNameError
        For a name that is neither.
    """
    wanted = set(names)
    known = [*dict.fromkeys(case.theme for case in CASES), *(case.name for case in CASES)]
    for name in wanted.difference(known):
        raise UnknownNameError("case", name, known)
    return tuple(case for case in CASES if not wanted or {case.name, case.theme} & wanted)
