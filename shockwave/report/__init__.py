"""One self-contained HTML page for one scenario: results, decision, pictures, input and provenance.

It needs the extra ``plot``. The page loads no other file, and every value in it is escaped.
"""

from shockwave.report.html_page import page, render_page
from shockwave.report.page_results import PageResults, compute_results
from shockwave.scenario.scene_hash import normalise, scene_hash

__all__ = ["PageResults", "compute_results", "normalise", "page", "render_page", "scene_hash"]
