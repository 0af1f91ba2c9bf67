"""Which cases of a long family run by default; the others are marked ``slow``."""

from collections.abc import Iterable
from typing import Any

import pytest


def thinned(cases: Iterable[Any], every: int) -> list[Any]:
    """The cases; all but every ``every``-th one, from the first on, are slow."""
    return [_slow(case, index % every > 0) for index, case in enumerate(cases)]


def keeping(cases: Iterable[Any], *kept: Any) -> list[Any]:
    """The cases; all but those ``kept`` are slow."""
    return [_slow(case, case not in kept) for case in cases]


def _slow(case: Any, slow: bool) -> Any:
    return pytest.param(case, marks=pytest.mark.slow) if slow else case
