"""The command that opens the explorer."""

from __future__ import annotations

import argparse

from shockwave.page.explorer import serve


def explore(options: argparse.Namespace) -> int:
    """Serve the page until an interrupt."""
    serve(options.file, options.port, not options.no_browser)
    return 0
