"""Check that every link inside the built documentation leads somewhere: ``check_links.py FOLDER``."""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_EXTERNAL = re.compile(r"[a-z]+:|//")


class _Page(HTMLParser):
    """The anchors of a page and the addresses that it refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.addresses: set[str] = set()
        self.feed(text)

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value and not _EXTERNAL.match(value):
                self.addresses.add(unquote(value))


def main(folder: str) -> int:
    """Print the links that lead nowhere; the status is 1 if there are any."""
    files = sorted(Path(folder).resolve().rglob("*.html"))
    pages = {file: _Page(file.read_text(encoding="utf-8")) for file in files}
    count = dead = 0
    for file, page in pages.items():
        for address in sorted(page.addresses):
            parts = urlsplit(address)
            place = (file.parent / parts.path).resolve() if parts.path else file
            count += 1
            if not place.exists() or (place in pages and parts.fragment not in {"", *pages[place].anchors}):
                dead += 1
                print(f"{file.relative_to(Path(folder).resolve())}: {address} leads nowhere")
    print(f"{count} links inside, {dead} of them dead")
    return int(dead > 0 or not count)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
