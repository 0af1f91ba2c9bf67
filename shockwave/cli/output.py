"""What commands print and write."""

from __future__ import annotations

import json
import sys

from shockwave.files import write_file

__all__ = ["DEBUG", "internal", "print_json", "written"]

#: The variable that shows where an internal error comes from.
DEBUG = "SHOCKWAVE_DEBUG"


def internal(error: Exception) -> str:
    """A sentence on an error that nobody foresaw."""
    return f"internal error: {type(error).__name__}: {error} ({DEBUG}=1 shows where; please report it)"


def print_json(document: object) -> None:
    print(json.dumps(document, indent=2, allow_nan=False))


def written(text: str, output: str | None, anew: bool) -> int:
    """Write ``text`` to the file ``output``, which ``anew`` must not exist, or to stdout."""
    if not output:
        print(text, end="")
        return 0
    write_file(output, text, anew)
    print(f"{output}: written", file=sys.stderr)
    return 0
