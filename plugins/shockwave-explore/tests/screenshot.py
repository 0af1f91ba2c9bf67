"""The screenshot of the documentation: run this file to take it again.

The picture contains the text that it shows, without its numbers. A test compares this text and, coarsely, the pixels,
because fonts and last digits differ between computers.
"""

from __future__ import annotations

import base64
import io
import re
import tempfile
from pathlib import Path

import numpy as np
from browser import Page, opened
from PIL import Image, PngImagePlugin

SCREENSHOT = Path(__file__).parents[3] / "docs" / "explore" / "screenshot.png"
# Seconds of the animation that have passed.
TIME = 2.2
# Cells of the comparison of pixels, about as wide as a picture is high on the page, and their mean difference.
CELLS = (24, 18)
MOST = 6.0
# Size of the page down to the fourth chart.
SIZE = "return [innerWidth, document.querySelectorAll('figure')[4].getBoundingClientRect().bottom + scrollY + 12]"
SHOWN = """
const parts = "h1, h2, legend, label, button, select, input[type=text], #headline, #results, figcaption, svg text";
return [...document.querySelectorAll(parts)].map((e) => e.value || e.textContent).join("\\n");
"""


def take(page: Page, file: Path) -> None:
    """Write the screenshot of the page at its start."""
    page.open()
    page.run("if (!paused) document.getElementById('pause').click()")
    page.run(f"for (const picture of document.querySelectorAll('#figures svg')) picture.setCurrentTime({TIME})")
    text = PngImagePlugin.PngInfo()
    text.add_text("Description", re.sub(r"[0-9][0-9.]*(e-[0-9]+)?", "0", str(page.run(SHOWN))))
    width, height = page.run(SIZE)
    clip = {"captureBeyondViewport": True, "clip": {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}}
    pixels = base64.b64decode(page.driver.execute_cdp_cmd("Page.captureScreenshot", clip)["data"])
    picture = Image.open(io.BytesIO(pixels)).convert("RGB").quantize(128, dither=Image.Dither.NONE)
    picture.save(file, optimize=True, pnginfo=text)


def difference(first: Path, second: Path) -> str:
    """In what two screenshots differ; empty if they are alike."""
    pictures = [Image.open(file) for file in (first, second)]
    texts = [picture.info.get("Description", "").split("\n") for picture in pictures]
    if texts[0] != texts[1]:
        return f"text: {set(texts[0]) ^ set(texts[1]) or 'another order'}"
    cells = [np.asarray(picture.convert("L").resize(CELLS, Image.Resampling.BOX), dtype=float) for picture in pictures]
    mean = float(np.abs(cells[0] - cells[1]).mean())
    return "" if mean < MOST else f"pixels: mean difference {mean:.1f}"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, opened(Path(folder)) as page:
        take(page, SCREENSHOT)
