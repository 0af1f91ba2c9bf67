"""What runs in a process of its own: one case, its finding written to stdout as JSON."""

from __future__ import annotations

import json
import math
import signal
import sys
import time
import traceback
from typing import Any, cast

from attrs import asdict

from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.catalogue import find
from shockwave.simulation.backend import Backend

__all__ = ["answer", "checked"]


def checked(case: Case, backend: Backend) -> tuple[Finding, float]:
    """The finding of a case, and the seconds that it took; what it raises is a fault of it."""
    begin = time.perf_counter()
    try:
        finding = case.check(backend)
    except Exception as error:  # whatever it is, it is not what must happen
        place = traceback.extract_tb(error.__traceback__)[-1]
        told = f"{type(error).__name__}: {error}"
        finding = Finding(outcome=told, faults=(f"raised in {place.name}, line {place.lineno}",))
    return finding, time.perf_counter() - begin


def answer(name: str, backend: str) -> None:
    """Run the case of this name and write what was found."""
    (case,) = find([name])
    if hasattr(signal, "alarm"):  # for one whose parent was ended, and can stop it no more
        signal.alarm(math.ceil(case.limit) + 5)
    finding, seconds = checked(case, cast(Backend, backend))
    document: dict[str, Any] = {**asdict(finding), "seconds": seconds}
    # Not a number is written as such, and told by who reads it.
    json.dump(document, sys.stdout)
