"""One self-contained page for one scenario: what was asked, what is predicted, what the simulation found, pictures.

It needs the extra ``plot``. Nothing in the page is loaded from elsewhere, and every value in it is escaped.
"""

from shockwave.page.findings import Findings, findings
from shockwave.page.whole import page, written
from shockwave.scenario.scene_hash import normalised, scene_hash

__all__ = ["Findings", "findings", "normalised", "page", "scene_hash", "written"]
