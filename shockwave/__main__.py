"""``python -m shockwave``: the command line."""

import sys

from shockwave.cli import main

sys.exit(main())
