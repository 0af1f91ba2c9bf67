"""``python -m shockwave``: the command line."""

import sys

from shockwave.cli import command

sys.exit(command())
