"""The command record: keys for a record file."""

from __future__ import annotations

import json
import os
from argparse import Namespace
from pathlib import Path

from shockwave.base.errors import InvalidValueError, UsageError
from shockwave.cli.output import PICTURES, check_output, print_result, write_output, write_result
from shockwave.studies.record_keys import propose_keys

_CHAIN = "chain: {material: bearing-steel-52100, diameter: 9.5 mm}  # state yours\n"


def record(options: Namespace) -> int:
    """Propose the keys of a record, and write a scenario or a picture of it."""
    check_output(options.output, ".yaml", ".yml")
    check_output(options.picture, *PICTURES)
    folder = os.path.dirname(options.output or options.file)
    if os.path.relpath(options.file, folder or os.curdir).startswith(os.pardir):
        raise UsageError(f"--output: must be in the folder of the record or above it (got {options.output})")
    result = propose_keys(options.file)
    print_result(result, options.json)
    if options.output:
        guesses = ", ".join(filter(None, [result.force_condition, result.time_condition]))
        # the name heads all results
        name = f"name: {json.dumps(f'{Path(options.output).stem}, {guesses}')}  # until they are stated\n"
        write_output((name if guesses else "") + _CHAIN + result.shock(folder), options.output, anew=True)
    if options.picture and result.pulse:
        write_result(result, options.picture, size="page")
    return 0 if result.pulse else InvalidValueError.exit_code
