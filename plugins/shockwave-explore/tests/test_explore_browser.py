"""The explorer in headless Chromium: sliders, links, pictures and the width of a phone."""

from __future__ import annotations

import json
import os
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from urllib.parse import quote, unquote

import pytest
from browser import CHROMIUM, DRIVER, Page, opened
from screenshot import SCREENSHOT, difference, take
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from test_explore import CHAIN, SHOCK

from shockwave_explore.scene import PRESETS, text_of_file

pytestmark = pytest.mark.skipif(
    not ((CHROMIUM and DRIVER) or os.environ.get("CI")), reason="chromium and chromium-driver are not installed"
)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with opened(tmp_path_factory.mktemp("chromium")) as page:
        yield page


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


def test_a_chain_that_was_endless_has_its_granules_again(page: Page) -> None:
    page.open()
    page.after(lambda: page.fill("chain.granules", "17"))
    for end in ("endless chain", "free end"):
        page.after(lambda: Select(page.find('[id="chain.end"]')).select_by_visible_text(end))  # noqa: B023
    assert page.value("chain.granules") == "17"


def test_a_link_restores_everything_that_was_set(page: Page) -> None:
    page.open()
    for name, choice in (("shock.profile", "triangular"), ("chain.material", "brass-260"), ("chain.end", "wall: ptfe")):
        page.after(lambda: Select(page.find(f'[id="{name}"]')).select_by_visible_text(choice))  # noqa: B023
    for name, value in (("shock.duration", "70"), ("chain.granules", "20"), ("simulate.until", "3")):
        page.after(lambda: page.fill(name, value))  # noqa: B023
    page.after(lambda: page.find('[data-for="chain.diameter"]').send_keys(Keys.ARROW_RIGHT))
    states = "return [...document.querySelectorAll('#controls [id]')].map((e) => [e.id, e.value ?? e.textContent])"
    fields = [pair for pair in page.run(states) if not pair[0].endswith(":slider")]
    page.until(lambda: quote(page.value("text")) in page.driver.current_url.replace("'", "%27"))
    link, headline = page.driver.current_url, page.html("headline")
    page.driver.get("about:blank")
    page.driver.get(link)
    page.until(lambda: page.shown)
    assert [pair for pair in page.run(states) if not pair[0].endswith(":slider")] == fields
    assert ["shock.duration", "70 us"] in fields
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
    assert "not the address of the running explorer" in page.until(lambda: page.error("answer"))


def test_a_hostile_link_is_refused_with_a_message_and_runs_nothing(page: Page) -> None:
    evil = "<img src=x onerror=document.title='evil'>"
    page.open(f"{CHAIN}\n{SHOCK.replace('1 N', repr(evil))}")
    fault = page.until(lambda: page.error("answer"))
    assert "shock.peak_force: must be a force" in fault
    assert evil in fault
    assert "force on the wall" in page.html("headline")
    page.open(f"name: {evil!r}\n{CHAIN}\n{SHOCK}")
    assert page.error("answer") == ""
    assert page.driver.title == "shockwave explore"


@pytest.mark.parametrize("text", ["chai", "chain: {material: pt"])
def test_a_link_that_was_cut_off_is_incomplete(text: str, page: Page) -> None:
    page.open(text)
    assert page.until(lambda: page.error("answer")).startswith("the link is incomplete: line 1")


def test_a_wrong_value_stays_at_its_field_with_a_message_until_escape(page: Page) -> None:
    page.open()
    headline = page.html("headline")
    field = page.fill("shock.rise_time", "15 kg")
    message = page.until(lambda: page.error("shock.rise_time"))
    assert message.startswith("must be a time, such as '15 us' (got '15 kg'")
    assert (field.get_attribute("value"), field.get_attribute("aria-invalid")) == ("15 kg", "true")
    assert field.get_attribute("aria-describedby") == "shock.rise_time:error"
    assert page.html("headline") == headline
    field.send_keys(Keys.ESCAPE)
    assert (field.get_attribute("value"), field.get_attribute("aria-invalid")) == ("24 us", "false")
    assert page.error("shock.rise_time") == ""


def test_a_message_names_other_values_by_their_labels(page: Page) -> None:
    page.open(f"{CHAIN}\n{SHOCK}")
    page.fill("shock.duration", "0.5 us")
    assert page.until(lambda: page.error("shock.duration")).startswith(
        "rise time: must be shorter than the duration, 500 ns"
    )


def test_another_control_works_beside_a_wrong_value(page: Page) -> None:
    page.open()
    page.fill("shock.rise_time", "15 kg")
    page.until(lambda: page.error("shock.rise_time"))
    slider = page.find('[data-for="shock.peak_force"]')
    page.after(lambda: slider.send_keys(Keys.ARROW_RIGHT))
    assert page.error("shock.rise_time")
    assert page.value("shock.rise_time") == "15 kg"
    assert f"peak_force: {page.value('shock.peak_force')}" in page.value("text")


def test_values_that_are_valid_only_together_can_be_given_one_after_the_other(page: Page) -> None:
    page.open(f"{CHAIN}\nshock: {{profile: triangular, peak_force: 5 N, rise_time: 10 us, duration: 40 us}}")
    page.fill("shock.rise_time", "50 us")
    page.until(lambda: page.error("shock.rise_time"))
    page.after(lambda: page.fill("shock.duration", "200 us"))
    assert (page.error("shock.rise_time"), page.value("shock.duration_ratio")) == ("", "4")
    assert "rise_time: 50 us" in page.value("text")


def test_a_bare_number_has_the_unit_that_the_field_shows(page: Page) -> None:
    page.open()
    page.after(lambda: page.fill("shock.rise_time", "0.01 ms"))
    page.after(lambda: page.fill("shock.rise_time", "0.02"))
    assert page.value("shock.rise_time") == "0.02 ms"
    assert "rise_time: 0.02 ms" in page.value("text")


def test_times_that_follow_from_others_follow_a_slider(page: Page) -> None:
    page.open()
    slider = page.find('[data-for="shock.rise_time"]')
    page.after(lambda: slider.send_keys(Keys.ARROW_RIGHT))
    rise_time, duration = (float(page.value(f"shock.{name}").split()[0]) for name in ("rise_time", "duration"))
    assert duration == pytest.approx(2 * rise_time)


def test_text_that_is_being_typed_stays_when_an_answer_arrives(page: Page) -> None:
    page.open()
    page.after(lambda: page.fill("shock.rise_time", "20 us", Keys.TAB, Keys.TAB, "7"))
    assert page.run("return document.activeElement.id") == "shock.duration"
    assert page.value("shock.duration") == "7"


def test_reset_returns_to_the_scenario_that_was_opened_or_chosen(page: Page) -> None:
    page.open()
    page.after(lambda: Select(page.find("#preset")).select_by_visible_text("A heavy striker"))
    text = page.value("text")
    page.after(lambda: page.fill("impact.velocity", "0.2"))
    page.fill("chain.diameter", "none")
    page.until(lambda: page.error("chain.diameter"))
    page.after(page.find("#reset").click)
    assert page.value("text") == text
    assert (page.value("impact.velocity"), page.value("chain.diameter")) == ("0.1 m/s", "9.5 mm")
    assert (page.error("chain.diameter"), page.value("preset")) == ("", "striker")


def test_an_error_in_the_text_is_shown_below_it_and_selected(page: Page) -> None:
    page.open()
    page.run("arguments[0].value = arguments[0].value.replace('48 us', '48 kg')", page.find("#text"))
    page.find("#apply").click()
    assert page.until(lambda: page.error("text")).startswith("line 11: shock.duration: must be a time")
    selected = "const t = document.activeElement; return t.value.slice(t.selectionStart, t.selectionEnd)"
    assert page.run(selected) == "  duration: 48 kg"


def test_text_that_is_not_applied_is_not_lost(page: Page) -> None:
    page.open()
    page.find("#text").send_keys("limit: {force: 60 N}")
    text = page.value("text")
    page.after(lambda: page.fill("chain.granules", "20"))
    assert page.value("text") == text
    assert "not yet applied" in page.find("#done").text
    page.after(page.find("#apply").click)
    assert "limit of 60 N" in page.html("results")
    assert (page.value("chain.granules"), page.find("#done").text) == ("40", "")


# ---------------------------------------------------------------- accessibility


@pytest.mark.parametrize("example", ["wall", "taper"])
def test_everything_that_takes_the_focus_has_a_name(example: str, page: Page) -> None:
    page.open(text_of_file(PRESETS[example]))
    nodes = page.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    focusable = [
        node
        for node in nodes
        if any(each["name"] == "focusable" and each["value"]["value"] for each in node.get("properties", ()))
        and node["role"]["value"] != "RootWebArea"
    ]
    assert {"combobox", "textbox", "slider", "button"} <= {node["role"]["value"] for node in focusable}
    assert [node for node in focusable if not node["name"]["value"]] == []
    assert all(node["name"]["value"] for node in nodes if node["role"]["value"] in ("image", "region"))


def test_the_keyboard_reaches_controls_in_order_and_shows_where_it_is(page: Page) -> None:
    page.open()
    page.run("document.activeElement.blur()")
    order = []
    for _ in range(8):
        page.driver.switch_to.active_element.send_keys(Keys.TAB)
        focused = page.driver.switch_to.active_element
        order.append(focused.get_attribute("id"))
        assert focused.value_of_css_property("outline-style") == "solid"
    assert order[:4] == ["preset", "reset", "shock.profile", "shock.peak_force"]
    assert order[4:] == ["shock.peak_force:slider", "shock.rise_time", "shock.rise_time:slider", "shock.duration"]


CONTRASTS = """
const linear = (c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
const light = (colour) => {
  const [r, g, b] = colour.match(/[0-9.]+/g).map(Number);
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
};
const behind = (e) => {
  const colour = getComputedStyle(e).backgroundColor;
  return colour !== "rgba(0, 0, 0, 0)" ? colour : behind(e.parentElement);
};
const written = (e) => [...e.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
const texts = [...document.querySelectorAll("body :not(svg *)")].filter(
  (e) => e.checkVisibility() && (written(e) || e.matches("input[type=text], select, textarea")),
);
return texts.map((e) => {
  const [a, b] = [light(getComputedStyle(e).color), light(behind(e))];
  return [e.outerHTML.slice(0, 60), (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)];
});
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_enough_contrast(scheme: str, page: Page) -> None:
    page.driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    )
    page.open(text_of_file(PRESETS["record"]))
    page.fill("shock.rise_time", "15 kg")
    page.until(lambda: page.error("shock.rise_time"))
    ratios = page.run(CONTRASTS)
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert len(ratios) > 40
    # level AA of WCAG 2.2
    assert [pair for pair in ratios if pair[1] < 4.5] == []


# ---------------------------------------------------------------- copies and files


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
    page.after(lambda: Select(page.find("#preset")).select_by_visible_text("A heavy striker"))
    assert page.value("impact.velocity") == "0.1 m/s"


def test_a_picture_is_saved_as_a_whole(page: Page, tmp_path: Path) -> None:
    page.open()
    behaviour = {"behavior": "allow", "downloadPath": str(tmp_path)}
    page.driver.execute_cdp_cmd("Page.setDownloadBehavior", behaviour)
    page.find("[aria-label='The shock'] .save").click()
    file = tmp_path / "The shock.svg"
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
    page.open(text_of_file(PRESETS[name]), width=390)
    assert page.run("return document.documentElement.scrollWidth") <= 390
    assert page.find("figure svg").size["width"] > 300
    heights = "return [...document.querySelectorAll('main :is(button, select, input)')].map((e) => e.offsetHeight)"
    assert min(page.run(heights)) >= 44  # the width of a finger


def test_the_controls_stay_beside_the_last_picture(page: Page) -> None:
    page.open()
    page.run("document.querySelector('figure:last-child').scrollIntoView()")
    top, bottom, height = page.run(
        "const { top, bottom } = $('controls').getBoundingClientRect(); return [top, bottom, innerHeight]"
    )
    assert 0 <= top < bottom <= height


def test_the_screenshot_of_the_documentation_is_current(page: Page, tmp_path: Path) -> None:
    take(page, tmp_path / "now.png")
    assert difference(SCREENSHOT, tmp_path / "now.png") == ""
