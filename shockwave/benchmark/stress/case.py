"""What an entry of the catalogue is, and what running it finds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from attrs import frozen

from shockwave.simulation.backend import Backend

__all__ = ["Case", "Check", "Finding"]


@frozen(kw_only=True)
class Finding:
    """What came of a case.

    Attributes
    ----------
    outcome : str
        The figures found, or the error and its words.
    error, bound : float or None
        Relative error against the reference of the case, and how large it may be; None where an error must be raised.
    momentum_defect : float or None
        Momentum in the chain against the impulse, relative; None where nothing was integrated.
    faults : tuple of str
        What should not have been; none where the case passes.
    """

    outcome: str
    error: float | None = None
    bound: float | None = None
    momentum_defect: float | None = None
    faults: tuple[str, ...] = ()


Check: TypeAlias = Callable[[Backend], Finding]


@frozen(kw_only=True)
class Case:
    """One extreme.

    Attributes
    ----------
    name, theme : str
        What it is called, and the part of the catalogue in which it stands.
    asked, must : str
        What is asked, and what must happen.
    check : Check
        Does it, with one of the two codes. What it raises is a fault.
    limit : float
        Time after which it counts as hung [s].
    slow : bool
        Whether it takes seconds even with the compiled code.
    twice : bool
        Whether it is another case with the other code; a method of NumPy alone is not.
    """

    name: str
    theme: str
    asked: str
    must: str
    check: Check
    limit: float = 60.0
    slow: bool = False
    twice: bool = True
