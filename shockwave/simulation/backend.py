"""The choice between the two codes that step a chain: the compiled file, or NumPy."""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from types import ModuleType
from typing import Literal, TypeAlias

from shockwave.errors import InvalidValueError

compiled: ModuleType | None = None
with suppress(ImportError):  # built without a C compiler
    compiled = import_module("shockwave.simulation._compiled")


Backend: TypeAlias = Literal["compiled", "numpy"]

#: Name -> what it is.
BACKENDS = {
    "compiled": "one C file, eight shocks side by side",
    "numpy": "NumPy alone, the reference",
}


def lack() -> str:
    """Why there is no compiled code; empty where there is."""
    if compiled is not None:
        return ""
    return "not built: needs a C compiler, and is not available on Windows or free-threaded Python"


def chosen(backend: str) -> ModuleType | None:
    """The compiled module for ``auto`` (if it was built) and ``compiled``, None for ``numpy``.

    Raises
    ------
    InvalidValueError
        When the name is unknown, or ``compiled`` is asked for and was not built.
    """
    if backend not in ("auto", *BACKENDS):
        raise InvalidValueError.of("backend", f"must be auto, compiled or numpy (got {backend!r})")
    if backend == "compiled" and compiled is None:
        raise InvalidValueError.of("backend", f"must be auto or numpy here (got 'compiled', which is {lack()})")
    return None if backend == "numpy" else compiled
