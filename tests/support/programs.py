"""Programs that run in an interpreter of their own, and the modules that they load."""

import argparse
import subprocess
import sys
from functools import cache
from pathlib import Path

from shockwave.cli.parser import parser

ROOT = Path(__file__).parents[2]
SCENE = "profiles/paper/table2-row1.yaml"


@cache
def loaded(program: str) -> set[str]:
    """Modules in memory after ``program`` has run in an interpreter of its own."""
    run = subprocess.run(
        [sys.executable, "-c", f"{program}\nimport sys; print(*sys.modules, file=sys.stderr)"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return set(run.stderr.split())


def command(*arguments: str) -> str:
    return f"from shockwave.cli import main; assert main({list(arguments)!r}) == 0"


def commands() -> list[str]:
    """Names of all commands."""
    action = next(a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    return list(action.choices)
