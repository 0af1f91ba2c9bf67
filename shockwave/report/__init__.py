"""One self-contained HTML page for one scenario: results, decision, pictures, input and provenance.

It needs the extra ``plot``. The page loads no other file, and every value in it is escaped.
"""

from shockwave.report.html_page import page, written
from shockwave.report.page_results import Findings, findings
from shockwave.scenario.scene_hash import normalise, scene_hash

__all__ = ["Findings", "findings", "normalise", "page", "scene_hash", "written"]
