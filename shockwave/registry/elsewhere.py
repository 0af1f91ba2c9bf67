"""Names that are not built in but known: which distribution to install for them."""

from __future__ import annotations

from typing import Final

__all__ = ["ELSEWHERE"]

#: (kind, name) -> distribution.
ELSEWHERE: Final[dict[tuple[str, str], str]] = {}
