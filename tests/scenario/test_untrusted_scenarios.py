"""Scenarios from elsewhere, such as over a network: no key, block or plugin makes them read a file."""

import os
import sys
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from shockwave.base.errors import ScenarioError
from shockwave.registry import registry
from shockwave.scenario.block_keys import BLOCKS, CHAIN, SCENARIO, SHOCK, Key, keys_of, parameters_of
from shockwave.scenario.chain_blocks import CELL, END, IMPACT, MODEL, SEGMENT, TAPER
from shockwave.scenario.published_results import Published
from shockwave.scenario.scenario import Scenario, parse_scenario
from shockwave.scenario.sweep_block import SWEEP
from shockwave.scenario.value_conversion import convert
from shockwave.scenario.variations import Family
from shockwave.scenario.yaml_document import parse_document
from shockwave.scene.force_limit import Limit
from shockwave.scene.material import Material
from support.fake_distributions import describe, on_path
from support.pages import ROOT, workplace
from support.scenario_texts import CHAIN as COPPER
from support.scenario_texts import SHOCK as TRIANGULAR

SECRET = "secret.txt"
# A profile and a contact law that open what their parameters name, however these are declared.
PLUGIN = """
import attrs
from pathlib import Path
from typing import Any, Literal
from shockwave.hooks import Entry, hookimpl

KEYS = {"text": str, "place": Path, "either": float | str, "perhaps": str | None, "files": list[str], "bare": list,
        "pair": tuple[str, float], "anything": Any, "mapping": dict[str, str], "chosen": Literal["a"] | str}

def opened(value):
    if isinstance(value, dict):
        value = [*value, *value.values()]
    for each in value if isinstance(value, list | tuple) else [value]:
        if isinstance(each, str | Path):
            raise ValueError(Path(each).read_text())

def made(base, **members):
    names = {name: attrs.field(default=None, type=kind) for name, kind in KEYS.items()}
    def check(self):
        for name in KEYS:
            opened(getattr(self, name))
    return attrs.make_class("Opening", names, bases=(base,), frozen=True, kw_only=True,
                            class_body={"__attrs_post_init__": check, **members})

def __getattr__(name):
    from shockwave import ContactLaw, Triangular
    if name == "Profile":
        return made(Triangular)
    if name == "Law":
        return made(ContactLaw, force=lambda self, overlap, *_: overlap)
    raise AttributeError(name)

@hookimpl
def shockwave_profiles():
    return [Entry("opening", "opening_plugin:Profile", "opens files")]

@hookimpl
def shockwave_contacts():
    return [Entry("opening-law", "opening_plugin:Law", "opens files")]
"""
#: Keys of shockwave's own blocks that take any text: it is shown, or the name of something that is registered.
PLAIN = {"name", "requires", "source", "material", "wall", "model", "profile", "momentum_coefficient"}
#: Keys that are blocks.
INNER = {key.name for key in SCENARIO if key.annotation is Any}
INNER |= {"parameters", "damping", "contact", "end", "cell", "grid", "zip", "points"}

OWN = (*SCENARIO, *CHAIN, *SHOCK, *SEGMENT, *CELL, *TAPER, *END, *IMPACT, MODEL, *SWEEP)
CLASSES = (Limit, Published, Material)

opened: list[str] = []


def note_opening(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open" and SECRET in os.fsdecode(arguments[0] if isinstance(arguments[0], str | bytes) else b""):
        opened.append(event)


@pytest.fixture(scope="module", autouse=True)
def plugin(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    folder = tmp_path_factory.mktemp("plugin")
    with workplace(folder) as patch:
        (folder / SECRET).write_text("0,1\n1,hunter2\n")
        (folder / "opening_plugin.py").write_text(PLUGIN)
        describe(folder, "opening-plugin", "1.0", {"opening": "opening_plugin"})
        on_path(folder, patch)
        patch.chdir(folder)
        sys.addaudithook(note_opening)  # it cannot be removed
        opened.clear()  # a hook of an earlier set-up in this process has noted the writing of the file
        yield


def untrusted(text: str) -> Scenario:
    return parse_scenario(parse_document(text, "link", names_files=False), None)


def free(keys: tuple[Key, ...]) -> list[str]:
    """Names of the keys whose values can be any text."""
    names = []
    for key in keys:
        try:
            names += [key.name] * (key.spec is None and not key.kind and convert(key, SECRET) == SECRET)
        except ValueError:
            continue
    return names


def test_only_names_and_remarks_of_own_blocks_take_text() -> None:
    keys = (*OWN, *(key for cls in CLASSES for key in keys_of(cls)), *(key for keys in BLOCKS.values() for key in keys))
    assert set(free(keys)) <= PLAIN | INNER


OPENING = "shock: {profile: opening, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2"
LAW = f"{COPPER.rstrip()[:-1]}, granules: 5, contact: {{model: opening-law%s}}}}\n{TRIANGULAR}"
#: Texts as values, bare and inside of others.
VALUES = (SECRET, f"[{SECRET}]", f"[[1, {SECRET}]]", f"{{{SECRET}: 1}}", f"{{a: {SECRET}}}")


def parameters(text: str) -> str:
    """A scenario with these parameters of a profile."""
    return f"{COPPER}{OPENING}{text and f', parameters: {{{text}}}'}}}\n"


def opening_keys() -> Iterator[tuple[Callable[[str], str], str]]:
    """A scenario as a function of a parameter, for every parameter of a registered class that takes text."""
    for entry in registry.entries("profiles"):
        for name in free(parameters_of(entry.name, registry.load("profiles", entry.name))):
            yield (
                lambda text, profile=entry.name: parameters(text).replace("opening", profile),
                f"shock.parameters.{name}",
            )
    for entry in registry.entries("contacts"):
        for name in free(keys_of(registry.load("contacts", entry.name))):
            yield lambda text: LAW % (text and f", {text}"), f"chain.contact.{name}"


def test_every_key_that_opens_a_file_is_refused_in_every_block() -> None:
    cases = list(opening_keys())
    assert {name for _, name in cases} >= {"shock.parameters.file", "shock.parameters.mapping", "chain.contact.text"}
    for (scenario, name), value in product(cases, VALUES):
        blocks = (
            f"sweep: {{grid: {{{name}: [{value}]}}}}",
            f"sweep: {{zip: {{{name}: [{value}]}}}}",
            f"sweep: {{points: [{{{name}: {value}}}]}}",
            f"uncertainty: {{{name}: {value}}}",
        )
        alone = scenario(f"{name.rpartition('.')[2]}: {value}")
        for text in (alone, *(f"{scenario('')}{block}\n" for block in blocks)):
            with pytest.raises(ScenarioError) as refused:
                untrusted(text)
            assert "hunter2" not in str(refused.value)
    assert opened == []


def test_the_message_states_the_place_and_the_remedy() -> None:
    with pytest.raises(ScenarioError, match=r"link:2:.*shock.parameters.file: must not be text here.*of your own"):
        untrusted(parameters(f"file: {SECRET}").replace("opening", "tabulated"))


def test_values_from_a_program_do_not_make_it_read_a_file_either() -> None:
    with pytest.raises(ScenarioError, match="must not be text here"):
        Family(untrusted(parameters(""))).scenario({"shock.parameters.text": SECRET})
    assert opened == []


def test_the_plugin_opens_a_file_for_a_scenario_of_the_user() -> None:
    with pytest.raises(Exception, match="hunter2"):
        parse_scenario(parse_document(parameters(f"text: {SECRET}"), "own"), None)
    assert opened.pop() == "open"


@pytest.mark.parametrize("file", sorted((ROOT / "profiles").glob("*/*.yaml")), ids=lambda file: file.stem)
def test_a_scenario_that_names_no_file_is_admitted(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    if "file:" not in text:
        assert untrusted(text).chain.radius > 0
