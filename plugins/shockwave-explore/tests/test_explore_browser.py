"""The explorer in headless Chromium: sliders, links, pictures and the width of a phone."""

from __future__ import annotations

import json
import os
import shutil
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any
from urllib.parse import quote, unquote

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from test_explore import CHAIN, SHOCK, served

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not ((CHROMIUM and DRIVER) or os.environ.get("CI")), reason="chromium and chromium-driver are not installed"
)
FLAGS = (
    *("headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking"),
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


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    assert CHROMIUM, "chromium or google-chrome must be installed"
    assert DRIVER, "chromedriver must be installed"
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    for flag in (*FLAGS, f"user-data-dir={tmp_path_factory.mktemp('chromium')}"):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    with served() as (_, address):
        driver = webdriver.Chrome(options=options, service=Service(DRIVER))
        try:
            yield Page(driver, address)
        finally:
            driver.quit()


def test_the_page_shows_results_without_errors_and_loads_from_loopback_alone(page: Page) -> None:
    page.open()
    assert "force on the wall" in page.html("headline")
    assert page.html("figures").count("<svg") >= 5
    assert page.driver.get_log("browser") == []
    events = [json.loads(entry["message"])["message"] for entry in page.driver.get_log("performance")]
    sent = [event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"]
    assert {url for url in sent if not url.startswith((page.address, "data:", "about:", "chrome"))} == set()


def test_a_slider_changes_the_figures_the_text_and_the_link(page: Page) -> None:
    page.open()
    slider = page.find('[data-for="shock.peak_force"]')
    before = {name: page.html(name) for name in ("headline", "figures")}
    page.after(lambda: slider.send_keys(Keys.ARROW_RIGHT))
    for name, html in before.items():
        assert page.html(name) != html
    written = page.find('[id="shock.peak_force"]').get_attribute("value")
    assert written != "100 N"
    assert f"peak_force: {written}" in page.run("return document.getElementById('text').value")
    page.until(lambda: quote(f"peak_force: {written}") in page.driver.current_url)


def test_the_page_keeps_up_with_a_slider(page: Page) -> None:
    page.open()
    slider = page.find('[data-for="shock.rise_time"]')
    times = [page.after(lambda: slider.send_keys(Keys.ARROW_RIGHT)) for _ in range(10)]
    # about 0.1 s on a free machine; a busy one may take ten times as long
    assert median(times) < 1.0


def test_a_link_opens_the_state_that_it_holds(page: Page) -> None:
    page.open()
    slider = page.find('[data-for="chain.diameter"]')
    page.after(lambda: slider.send_keys(Keys.ARROW_RIGHT))
    page.until(lambda: "#" in page.driver.current_url)
    link, headline = page.driver.current_url, page.html("headline")
    page.driver.get("about:blank")
    page.driver.get(link)
    page.until(lambda: page.shown)
    assert page.html("headline") == headline


def test_a_link_of_another_explorer_can_be_applied(page: Page) -> None:
    page.open()
    link = f"http://127.0.0.1:8042/other/#{quote(f'{CHAIN}{chr(10)}{SHOCK}')}"
    page.run("document.getElementById('text').value = arguments[0]", link)
    page.after(page.find("#apply").click)
    assert page.run("return document.getElementById('text').value") == f"{CHAIN}\n{SHOCK}"


def test_a_page_of_an_explorer_that_has_ended_states_it(page: Page) -> None:
    page.open()
    page.run("history.replaceState(null, '', '/old/')")
    page.find("#apply").click()
    assert "not the address of the running explorer" in page.until(lambda: page.find("#fault").text)


def test_a_hostile_link_is_refused_with_a_message_and_runs_nothing(page: Page) -> None:
    evil = "<img src=x onerror=document.title='evil'>"
    page.open(f"{CHAIN}\n{SHOCK.replace('1 N', repr(evil))}")
    fault = page.until(lambda: page.find("#fault").text)
    assert "shock.peak_force: must be a force" in fault
    assert evil in fault
    assert "force on the wall" in page.html("headline")
    page.open(f"name: {evil!r}\n{CHAIN}\n{SHOCK}")
    assert not page.find("#fault").is_displayed()
    assert page.driver.title == "shockwave explore"


def test_a_wrong_value_is_refused_and_the_last_one_returns(page: Page) -> None:
    page.open()
    field = page.find('[id="shock.rise_time"]')
    field.clear()
    field.send_keys("15 kg", Keys.TAB)
    assert "shock.rise_time: must be a time" in page.until(lambda: page.find("#fault").text)
    assert field.get_attribute("value") == "12 us"


def test_the_scenario_and_its_link_can_be_copied(page: Page) -> None:
    allowed = {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"], "origin": page.address}
    page.driver.execute_cdp_cmd("Browser.grantPermissions", allowed)
    text = f"{CHAIN}\n{SHOCK}"
    page.open(text)
    for button, copied in (("copy", text), ("link", f"{page.address}#{text}")):
        page.run("document.getElementById('done').textContent = ''")
        page.find(f"#{button}").click()
        page.until(lambda: page.find("#done").text)
        assert unquote(page.run("return navigator.clipboard.readText()")) == copied


def test_an_example_can_be_chosen(page: Page) -> None:
    page.open()
    page.after(lambda: Select(page.find("#preset")).select_by_visible_text("striker"))
    assert page.find('[id="impact.velocity"]').get_attribute("value") == "0.4 m/s"


def test_a_picture_is_saved_as_a_whole(page: Page, tmp_path: Path) -> None:
    page.open()
    behaviour = {"behavior": "allow", "downloadPath": str(tmp_path)}
    page.driver.execute_cdp_cmd("Page.setDownloadBehavior", behaviour)
    page.run("document.querySelector('[aria-label=Pulse] .save').click()")
    file = tmp_path / "Pulse.svg"
    page.until(lambda: file.exists() and file.stat().st_size > 1000)
    assert ET.parse(file).getroot().tag == "{http://www.w3.org/2000/svg}svg"


def test_the_beads_move_until_they_are_paused(page: Page) -> None:
    page.open()
    place = "return document.querySelector('figure.wide circle:nth-of-type(3)').cx.animVal.value"
    before = page.run(place)
    page.until(lambda: page.run(place) != before)
    page.run("document.getElementById('pause').click()")
    before = page.run(place)
    time.sleep(0.5)
    assert page.run(place) == before


@pytest.mark.parametrize("name", ["wall", "damped", "power-law", "record"])
def test_a_phone_needs_no_horizontal_scrolling(name: str, page: Page) -> None:
    page.open(width=390)
    page.after(lambda: Select(page.find("#preset")).select_by_visible_text(name))
    assert page.run("return document.documentElement.scrollWidth") <= 390
    assert page.find("figure svg").size["width"] > 300
