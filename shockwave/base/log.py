"""The logger ``shockwave`` of long jobs, which writes nothing unless the user's program configures logging."""

from __future__ import annotations

import logging

logger = logging.getLogger("shockwave")
# otherwise Python would print warnings by itself
logger.addHandler(logging.NullHandler())
