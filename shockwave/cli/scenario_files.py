"""The scenarios that a command names: files or standard input, changed by its options."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from shockwave.base.errors import ShockwaveError, UsageError
from shockwave.base.files import refuse_inputs
from shockwave.scenario.changes import Change, apply_changes
from shockwave.scenario.scenario import Scenario, parse_scenario
from shockwave.scenario.yaml_document import STDIN, read_document, read_standard_input

# Argument that stands for standard input.
_DASH = "-"


def label_file(file: str) -> str:
    """Name of a file in messages."""
    return STDIN if file == _DASH else file


def name_of(scenario: Scenario) -> str:
    """Name of the file of a scenario in messages."""
    return STDIN if scenario.path is None else str(scenario.path)


def stem_of(file: str) -> str:
    """Beginning of the names of files that are written for a scenario."""
    return "stdin" if file == _DASH else Path(file).stem


def load_with_changes(file: str, options: Namespace, several: bool = False) -> Scenario:
    """Load the scenario in a file, with the changes of the options, whose errors name one of ``several`` files."""
    where = f" for {label_file(file)}" if several else ""
    changes = [Change.of(f"{option}{where}", path, text) for option, path, text in options.changes]
    if file == _DASH:
        return parse_scenario(apply_changes(read_standard_input(), changes), None)
    return parse_scenario(apply_changes(read_document(file), changes), Path(file))


def load_scenarios(options: Namespace, remedy: str = "", output: str | None = None) -> list[Scenario]:
    """Load scenarios of single scenes; ``remedy`` is the hint of the error for a sweep.

    Raises
    ------
    ShockwaveError
        With all errors of all files and the greatest of their exit statuses; or when ``output`` is an input file.
    """
    files: Sequence[str] = getattr(options, "files", None) or [options.file]
    scenarios = []
    errors: list[ShockwaveError] = []
    for file in files:
        try:
            scenario = load_with_changes(file, options, len(files) > 1)
        except ShockwaveError as error:
            errors.append(error)
            continue
        scenarios.append(scenario)
        if scenario.sweep is not None:
            got = f"got a sweep of {len(scenario.sweep)}; {remedy or f'run `shockwave sweep {file}`'}"
            errors.append(UsageError(f"{label_file(file)}: must describe a single case ({got})"))
    if errors:
        together = ShockwaveError("\n".join(map(str, errors)))
        together.exit_code = max(error.exit_code for error in errors)
        raise together
    if output:
        refuse_inputs(output, (file for scenario in scenarios for file in scenario.files))
    return scenarios
