"""The explorer in headless Chromium, for its tests and its screenshot."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from test_explore import served

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
FLAGS = (
    *(
        "headless",
        "hide-scrollbars",
        "no-sandbox",
        "disable-gpu",
        "disable-quic",
        "no-first-run",
        "disable-background-networking",
    ),
    *("disable-component-update", "disable-sync", "disable-dev-shm-usage", "window-size=1200,900"),
)
# Longest time between a change and the page that shows it on a busy machine [s].
LONGEST = 30.0


class Page:
    """The page in a browser."""

    def __init__(self, driver: webdriver.Chrome, address: str) -> None:
        self.driver, self.address = driver, address

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def until(self, condition: Callable[[], Any]) -> Any:
        end = time.monotonic() + LONGEST
        while not (found := condition()):
            assert time.monotonic() < end, "the page does not change"
            time.sleep(0.02)
        return found

    @property
    def shown(self) -> int:
        """Number of answers that the page has shown."""
        return int(self.run("return document.body.dataset.shown ?? 0"))

    def open(self, text: str = "", width: int = 1200) -> Page:
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.driver.get("about:blank")
        self.driver.get(self.address + (f"#{quote(text)}" if text else ""))
        self.until(lambda: self.shown)
        return self

    def fill(self, name: str, *keys: str) -> Any:
        """Write into a field, leave it, and return it."""
        field = self.find(f'[id="{name}"]')
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(*keys, *([Keys.TAB] if len(keys) == 1 else []))
        return field

    def value(self, name: str) -> str:
        return str(self.run("return document.getElementById(arguments[0]).value", name))

    def error(self, name: str) -> str:
        """The message at a field."""
        return str(self.run("return document.getElementById(arguments[0] + ':error').textContent", name))

    def find(self, selector: str) -> Any:
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def html(self, name: str) -> str:
        return str(self.run("return document.getElementById(arguments[0]).innerHTML", name))

    def after(self, change: Callable[[], object]) -> float:
        """Make a change, wait for the answer, and return the time between them [s]."""
        before, begin = self.shown, time.perf_counter()
        change()
        self.until(lambda: self.shown > before)
        return time.perf_counter() - begin


@contextmanager
def opened(folder: Path) -> Iterator[Page]:
    """The page of an explorer of its own, in a browser that keeps its data in ``folder``."""
    assert CHROMIUM, "chromium or google-chrome must be installed"
    assert DRIVER, "chromedriver must be installed"
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"user-data-dir={folder}"):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    with served() as (_, address):
        driver = webdriver.Chrome(options=options, service=Service(DRIVER))
        try:
            yield Page(driver, address)
        finally:
            driver.quit()
