"""Output of the commands: documents, files, and one sentence for each error."""

from __future__ import annotations

import json
import os
import sys

from shockwave.errors import ShockwaveError
from shockwave.files import write_file

#: The variable that shows where an internal error comes from.
_DEBUG = "SHOCKWAVE_DEBUG"


def failure(error: Exception) -> tuple[str, int]:
    """The message and the exit status for an error; with SHOCKWAVE_DEBUG, an internal error is raised instead."""
    if isinstance(error, ShockwaveError):
        return str(error), error.exit_code
    if os.environ.get(_DEBUG):
        raise error
    return f"internal error: {type(error).__name__}: {error} ({_DEBUG}=1 shows where; please report it)", 1


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
