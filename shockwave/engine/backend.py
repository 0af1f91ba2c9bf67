"""Choice between the two backends, compiled code and NumPy."""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from types import ModuleType
from typing import Literal, TypeAlias

from shockwave.base.errors import InvalidValueError

compiled: ModuleType | None = None
with suppress(ImportError):  # built without a C compiler
    compiled = import_module("shockwave.engine._lanes")


Backend: TypeAlias = Literal["compiled", "numpy"]

#: Descriptions by name.
BACKENDS = {
    "compiled": "compiled C, eight shocks in parallel (SIMD)",
    "numpy": "pure NumPy reference implementation",
}


def lack() -> str:
    """Reason why the compiled code is not available; empty if it is."""
    if compiled is not None:
        return ""
    return "not built: needs a C compiler; not available on Windows or free-threaded Python"


def compiled_code(backend: str) -> ModuleType | None:
    """The compiled module for ``compiled`` and, if it was built, for ``auto``; None for NumPy.

    Raises
    ------
    InvalidValueError
        If the name is unknown, or is ``compiled`` and the compiled code was not built.
    """
    if backend not in ("auto", *BACKENDS):
        raise InvalidValueError.of("backend", f"must be auto, compiled or numpy (got {backend!r})")
    if backend == "compiled" and compiled is None:
        raise InvalidValueError.of("backend", f"must be auto or numpy here (got 'compiled', which is {lack()})")
    return None if backend == "numpy" else compiled
