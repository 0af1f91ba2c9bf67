"""The documentation: scenarios load, commands print what is shown, code runs, tables and links are true.

`pages` states the conventions.
"""

import importlib
import inspect
import io
import json
import os
import re
import tomllib
import typing
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft7Validator

import shockwave as sw
from shockwave import hooks, pictures
from shockwave.base import quantities
from shockwave.cli.command_table import COMMANDS, Command
from shockwave.registry import built_ins, hook_specifications, registry
from shockwave.scenario import block_keys as keys
from shockwave.scenario import chain_blocks
from shockwave.scenario.published_results import Published
from shockwave.scenario.schema import schema
from shockwave.scene.force_limit import Limit
from shockwave.scene.sensors import Sensor
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.studies.quantities import targets_of
from support import acquisition_files, pages
from support.beyond_yield import BEYOND_YIELD, notes_of_sweeps, warnings_of, warns_beyond_yield
from support.fake_distributions import install
from support.pages import DOCS, PAGES, ROOT, Block, blocks_of, code_in, table
from support.programs import commands
from support.scenario_texts import schema_faults
from support.slow_cases import keeping

#: Pages of which commands and code take seconds.
LONG = [DOCS / f"{name}.md" for name in ("report", "pictures", "stress", "benchmarks")]
#: Commands on other pages that take more than five seconds: hundreds of simulations of a chain with soft granules.
LONG_COMMANDS = (
    "shockwave design cushion.yaml --vary chain.granules[0].diameter",
    "shockwave design layer.yaml",
    "shockwave uncertainty cushion.yaml",
    "shockwave uncertainty protector.yaml",
)
#: JSON is for programs; --wide asks for all columns; validate prints one line for each error, as editors expect.
NOT_WRAPPED = {"--json", "--wide", "validate"}


def is_quick(block: Block) -> bool:
    if block.language not in ("console", "python"):
        return True
    return block.page not in LONG and not any(command.startswith(LONG_COMMANDS) for command, _ in block.commands)


def of_language(*languages: str) -> Any:
    """The blocks of these languages, as parameters."""
    blocks = [block for page in PAGES for block in blocks_of(page) if block.language in languages]
    return pytest.mark.parametrize("block", keeping(blocks, *filter(is_quick, blocks)), ids=str)


@of_language("console")
def test_commands_print_what_is_shown(block: Block, tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    pages.prepare(tmp_path, block, patch)
    status = 0
    for command, shown in block.commands:
        output = io.StringIO()
        printed, status = pages.run(command, status, output)
        assert pages.agree(shown, printed), f"$ {command}\n{printed}"
        if not NOT_WRAPPED & set(command.split()):
            assert pages.widest(output.getvalue()) <= pages.PIPED, f"$ {command}\n{printed}"
        beyond = warns_beyond_yield([printed, *notes_of_sweeps(tmp_path)])
        assert not beyond or block.page.relative_to(ROOT).as_posix() in BEYOND_YIELD, f"$ {command}\n{printed}"


@of_language("yaml")
def test_scenarios_load_or_fail_as_stated(block: Block, tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    pages.prepare(tmp_path, block, patch)
    file, text = Path(block.directives.get("file", "scenario.yaml")), block.text
    if "fragment" in block.directives:
        base = Path(block.directives["fragment"])
        file = base.with_name("scenario.yaml")
        text = yaml.safe_dump({**yaml.safe_load(base.read_text(encoding="utf-8")), **yaml.safe_load(text)})
    file.write_text(text, encoding="utf-8")
    if "faulty" not in block.directives:
        assert sw.load_scenario(file).excitation is not None
        assert schema_faults(text, Draft7Validator(schema())) == []  # with the plugins of the page
        return
    with pytest.raises(sw.ScenarioError) as caught:
        sw.load_scenario(file)
    page = block.page.read_text(encoding="utf-8")
    assert [fault for fault in map(str, caught.value.faults) if fault not in page] == []


WITH_CODE = [page for page in PAGES if any(block.language in ("python", "pycon") for block in blocks_of(page))]


@pytest.mark.parametrize(
    "page", keeping(WITH_CODE, *set(WITH_CODE).difference(LONG)), ids=lambda page: str(page.relative_to(ROOT))
)
def test_code_runs(page: Path, tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    blocks = [block for block in blocks_of(page) if block.language in ("python", "pycon")]
    pages.prepare(tmp_path, blocks[-1], patch)
    names: dict[str, Any] = {}
    for block in blocks:
        if {"file", "needs"} & block.directives.keys():
            compile(block.text, str(block), "exec")
        else:
            pages.execute(block, names)
    beyond = warns_beyond_yield(warnings_of(names.values()))
    assert not beyond or page.relative_to(ROOT).as_posix() in BEYOND_YIELD


NEEDING = [block for page in PAGES for block in blocks_of(page) if "needs" in block.directives]


@pytest.mark.parametrize("block", NEEDING, ids=lambda block: block.directives["needs"])
def test_code_runs_with_the_package_that_it_needs(
    block: Block, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = block.directives["needs"]
    pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    acquisition_files.write_file(package)
    names: dict[str, Any] = {}
    pages.execute(block, names)
    assert names["pulse"].recorded_peak_force == pytest.approx(acquisition_files.FORCES.max())
    assert names["pulse"].recorded_rise_time == pytest.approx(100e-6)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_blocks_have_a_known_language(page: Path) -> None:
    known = {"console", "yaml", "python", "pycon", "toml", "text", "{eval-rst}", "{toctree}"}
    # the READMEs of plugins show how to install them, in blocks without a language
    unknown = {block.language for block in blocks_of(page)} - known
    assert unknown <= ({""} if "plugins" in page.parts else set())
    assert all(tomllib.loads(block.text) for block in blocks_of(page) if block.language == "toml")
    assert not re.search(rf"{os.sep}(?:home|tmp|work|Users)/", page.read_text(encoding="utf-8"))


#: Columns of code that a page of the documentation shows without scrolling; `docs/ruff.toml` has the same number.
WIDEST = 88


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.is_relative_to(DOCS)], ids=lambda page: str(page.relative_to(DOCS))
)
def test_code_is_not_wider_than_the_page(page: Path) -> None:
    shown = {"console": r"^\$ (?:.*\\\n)*.*", "pycon": r"^(?:>>>|\.\.\.) .*"}
    for block in blocks_of(page):
        code = re.findall(shown.get(block.language, ".+"), block.text, flags=re.MULTILINE)
        assert [line for part in code for line in part.splitlines() if len(line) > WIDEST] == [], str(block)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in set(re.findall(r"\]\(([^)\s]+)\)", pages.prose(page))):
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert "://" in target or file.exists(), target
        assert "://" in target or not page.is_relative_to(DOCS) or file.is_relative_to(DOCS), (
            f"{target}: not on the site"
        )
        assert "://" in target or not anchor or anchor in pages.anchors(file), target


def test_every_page_and_every_profile_is_listed() -> None:
    contents = [block for page in ("index.md", "api.md") for block in blocks_of(DOCS / page)]
    listed = " ".join(block.text for block in contents if block.language == "{toctree}").split()
    files = {page.relative_to(DOCS).with_suffix("").as_posix() for page in PAGES if page.is_relative_to(DOCS)}
    assert files - {"index"} <= set(listed)
    text = (ROOT / "profiles" / "README.md").read_text(encoding="utf-8")
    files = [file for file in (ROOT / "profiles").rglob("*") if file.suffix in (".yaml", ".csv")]
    assert [file for file in files if f"\n| `{file.relative_to(ROOT / 'profiles')}` |" not in text] == []


def cells_of(key: keys.Key) -> list[str]:
    """The row of docs/scenarios.md on a key: name, type, unit, default, range."""
    kind, rule = kind_and_rule(key)
    unit = key.spec.unit if key.spec is not None and key.spec.unit else "-"
    stated = key.default != "" and isinstance(key.default, str | float | bool)
    default = "required" if key.required else "-"
    if stated:
        value = str(key.default).lower() if isinstance(key.default, bool) else key.default
        default = f"`{value:g}`" if isinstance(value, float) else f"`{value}`"
    return [f"`{key.name}`", kind, unit, default, re.sub("a finite number( of)?", "-", rule)]


def kind_and_rule(key: keys.Key) -> tuple[str, str]:
    members = typing.get_args(key.annotation)
    listed = typing.get_origin(key.annotation) in (list, tuple)
    if key.spec is not None:
        kind = "whole number" if key.spec.whole else "number"
        kind = f"list of {kind}s" if key.spec.samples else kind
        return kind, key.spec.rule.removesuffix(f" {key.spec.unit}").removeprefix("a whole number ")
    choices = [one for one in (key.annotation, *members) if typing.get_origin(one) is typing.Literal]
    if choices:
        names = typing.get_args(choices[0])
        kind = "list of names" if listed else "whole number" if names == keys.VERSIONS else "name"
        return kind, ", ".join(f"`{name}`" for name in names)
    if key.annotation is bool:
        return "true or false", "-"
    if key.annotation is typing.Any:
        named = {"material": "name or mapping", "wall": "name or mapping", "cell": "list of segments"}
        return named.get(key.name, "mapping"), "-"
    if float in members:
        return "name or number" if str in members else "number", "-"
    if key.name == "sensors":
        return "list of sensors", "-"
    return "list of whole numbers" if listed and int in members else "list of text" if listed else "text", "-"


#: Parameters of each built-in profile.
OF_PROFILES = {
    entry.name: keys.parameters_of(entry.name, registry.load("profiles", entry.name))
    for entry in built_ins.ENTRIES["profiles"]
}
KEYS = {
    "scenario": keys.SCENARIO,
    "chain": keys.CHAIN,
    "material": keys.keys_of(sw.Material),
    "segment": chain_blocks.SEGMENT,
    "cell": chain_blocks.CELL,
    "taper": chain_blocks.TAPER,
    "end": chain_blocks.END,
    "bar": chain_blocks.BAR,
    "impact": chain_blocks.IMPACT,
    "motion": chain_blocks.MOTION[:6],
    "shock": keys.shock_keys(sw.PowerLaw),
    **{name: parameters for name, parameters in OF_PROFILES.items() if parameters},
    "predict": keys.keys_of(sw.Predictor),
    "simulate": keys.keys_of(SimulateOptions),
    "limit": keys.keys_of(Limit),
    "published": keys.keys_of(Published),
}


@pytest.mark.parametrize("name", KEYS)
def test_tables_of_keys_are_those_of_the_loader(name: str) -> None:
    assert [row[:5] for row in table("docs/scenarios.md", name)] == [cells_of(key) for key in KEYS[name]]


def test_table_of_profiles_is_the_registry() -> None:
    rows = {code_in(row[0])[0]: code_in(row[-1]) for row in table("docs/scenarios.md", "profiles")}
    listed = {name: [key.name for key in parameters] for name, parameters in OF_PROFILES.items()}
    assert list(rows) == list(listed)
    assert rows | {"tabulated": []} == listed | {"tabulated": []}


@pytest.mark.parametrize("kind", ["contacts", "integrators", "quadratures"])
def test_tables_of_registered_names_are_the_registry(kind: str) -> None:
    entries = (entry for entry in registry.entries(kind) if entry.distribution == sw.OWN_DISTRIBUTION)
    assert table("docs/scenarios.md", kind) == [[f"`{entry.name}`", entry.summary] for entry in entries]


def test_table_of_materials_is_the_library() -> None:
    rows = {code_in(name)[0]: cells for name, *cells in table("docs/scenarios.md", "materials")}
    entries = (entry for entry in registry.entries("materials") if entry.distribution == sw.OWN_DISTRIBUTION)
    assert list(rows) == [entry.name for entry in entries]
    for name, (modulus, poisson_ratio, density, strength, source) in rows.items():
        material = sw.material(name)
        assert (float(modulus), float(poisson_ratio), float(density), source) == (
            material.youngs_modulus / 1e9,
            material.poisson_ratio,
            material.density,
            material.source,
        )
        assert (None if strength == "-" else float(strength) * 1e6) == material.yield_strength


def test_table_of_dampings_is_the_registry() -> None:
    rows = {code_in(row[0])[0]: set(code_in(row[2])) for row in table("docs/scenarios.md", "dampings")}
    models = [entry.name for entry in built_ins.ENTRIES["contacts"] if entry.takes == "damping"]
    assert rows == {name: {key.name for key in keys.keys_of(registry.load("contacts", name))} for name in models}


def test_files_and_tests_of_changes_exist() -> None:
    rows = table("CONTRIBUTING.md", "changes")
    paths = {name for _, *cells in rows for cell in cells for name in code_in(cell) if "/" in name}
    assert len(paths) > 3 * len(rows)
    for path, _, name in (path.partition("::") for path in sorted(paths)):
        assert (ROOT / path).exists(), path
        assert not name or re.search(rf"^(def|class) {name}\b", (ROOT / path).read_text(), re.MULTILINE), name


#: Sweeps of the page -> their columns.
IN_SWEEPS: dict[str, Any] = {
    "simulate, compare": quantities.LEADING_WAVE,
    "predict": [each for each in quantities.PREDICTED if each not in quantities.SECTION4],
    "predict, compare": quantities.SECTION4,
    "compare": [each for each in quantities.COMPARED if each not in quantities.SECTION4],
    "`waves: train`": quantities.TRAIN,
    "finite chains": quantities.FINITE,
    "other chains": (*quantities.FORCES[1:], *quantities.FORCES_ERROR, *quantities.DISSIPATED),
    "other chains with elastic-plastic contacts": quantities.PLASTIC,
    "other chains with a wall": quantities.WALL,
    "other chains with a movable end": quantities.STRUCTURE,
    "other chains with a striker": quantities.STRIKER,
    "other chains, `contacts: [10]`": quantities.contact_forces([10]),
    "`limit`": quantities.VERDICT,
    "equal granules": quantities.SCALED,
    "all": quantities.NOTES,
}


def test_table_of_columns_of_sweeps_is_that_of_the_quantities() -> None:
    rows = [(where, each) for where, group in IN_SWEEPS.items() for each in group]
    assert table("docs/sweep-results.md", "columns") == [
        [f"`{each.column}`", each.unit or "-", each.meaning, where] for where, each in rows
    ]


@pytest.mark.parametrize("command", ["predict", "simulate"])
def test_units_of_json_keys_are_those_of_the_quantities(command: str) -> None:
    for keys_of_row, units, *_ in table("docs/commands.md", f"{command} --json"):
        names, stated = code_in(keys_of_row), units.split(", ")
        for name, unit in zip(names, stated * len(names) if len(stated) == 1 else stated, strict=units != ""):
            if unit and not name.startswith(("scene.", "conditions", "trace", "section4.areas")):
                assert (name, quantities.unit_of(name) or "-") == (name, unit)


def test_targets_of_a_design_are_those_of_its_page() -> None:
    text = (DOCS / "design.md").read_text(encoding="utf-8").partition("## Targets")[2].partition("```")[0]
    reported = (*quantities.contact_forces([0]), *quantities.sensor_figures([Sensor("wall")]))
    assert set(targets_of(reported)) <= set(code_in(text))


def flat(value: Any, path: str = "") -> set[str]:
    """Paths of all keys in a document: ``waves``, ``waves[].momentum``, ``cost.steps``."""
    if isinstance(value, dict):
        step = f"{path}." if path else ""
        return set().union(*({f"{step}{key}"} | flat(inner, f"{step}{key}") for key, inner in value.items()))
    if isinstance(value, list):
        return set().union(*(flat(inner, f"{path}[]") for inner in value))
    return set()


#: An ejection, and a train.
PAPER = "profiles/paper/table2-row1.yaml profiles/paper/table1-row1.yaml --rtol 1e-4"
PROTECTOR = "profiles/examples/protector.yaml"
#: A command that prints JSON, its arguments, and keys that it repeats elsewhere.
PRINTED = {
    "predict": (PAPER, "-"),
    "simulate": (PAPER, "-"),
    "compare": (PAPER, r"(predicted|simulated)\."),
    "validate": ("bad.yaml", "-"),
    "list profiles": ("", "-"),
    "list plugins": ("", "-"),
    "uncertainty": (f"{PROTECTOR} --draws 64", "-"),
    "spectrum": ("profiles/examples/triangular.yaml --set chain.granules=5 --mass 1kg", "-"),
    "record": ("profiles/examples/hammer.csv", r"without\.\w+\."),
    "design": (
        f"{PROTECTOR} --vary chain.diameter --target 'peak_force=10 N' --between '15 mm' '50 mm'",
        r"(nearest|table)(\[\])?\.|solutions\[\]\.(quantities|errors)\.",
    ),
}


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("command", PRINTED)
def test_json_keys_are_those_printed(command: str, tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    arguments, repeated = PRINTED[command]
    install(tmp_path, ROOT / "plugins" / "shockwave-pulses" / "pyproject.toml", patch)
    (tmp_path / "bad.yaml").write_text("shock: {}\n", encoding="utf-8")
    printed, _ = pages.run(f"shockwave {command} {arguments} --json", 0)
    listed = {key for row in table("docs/commands.md", f"{command} --json") for key in code_in(row[0])}
    found = {key.removeprefix("[].") for key in flat(json.loads(printed))}
    assert listed == {key for key in found if not re.match(repeated, key)}


def test_every_command_is_listed() -> None:
    assert [code_in(row[0])[0] for row in table("docs/commands.md", "commands")] == commands()


@pytest.mark.parametrize("command", [each for each in COMMANDS if each.options], ids=lambda each: each.name)
def test_options_on_the_page_are_those_of_the_command(command: Command) -> None:
    rows = [[", ".join(f"`{name}`" for name in option.usage), option.help] for option in command.options]
    assert table("docs/commands.md", f"options of {command.name}") == rows


def test_exit_statuses_are_those_of_the_errors() -> None:
    rows = table("docs/commands.md", "exit statuses")
    listed = {name: int(code_in(row[0])[0]) for row in rows for name in code_in(row[2])}
    errors = {name: getattr(sw, name) for name in sw.__all__ if name.endswith("Error")}
    assert listed == {name: error.exit_code for name, error in errors.items() if name != "ShockwaveError"}


def test_names_for_plugins_are_listed_and_their_classes_have_a_page() -> None:
    listed = [name for row in table("docs/plugins.md", "names of hooks") for name in code_in(row[0])]
    assert sorted(listed) == hooks.__all__
    classes = {f"shockwave.hooks.{name}" for name in listed if inspect.isclass(getattr(hooks, name))}
    assert {name for name in WITH_A_PAGE if name.startswith("shockwave.hooks.")} == classes
    specified = {name for name in vars(hook_specifications) if name.startswith("shockwave_")}
    assert {code_in(row[0])[0] for row in table("docs/plugins.md", "hooks")} == specified


#: Names that have a page of their own: those listed by ``autosummary``.
WITH_A_PAGE = [
    name
    for page in sorted(DOCS.glob("python/*.md"))
    for name in re.findall(r"^   ~?(shockwave\.[\w.]+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
]


def test_every_public_name_has_one_page() -> None:
    assert sorted(name for name in WITH_A_PAGE if name.count(".") == 1) == sorted(f"shockwave.{n}" for n in sw.__all__)
    assert len(WITH_A_PAGE) == len(set(WITH_A_PAGE))
    drawn = {f"shockwave.pictures.{name}" for name, own in vars(pictures).items() if inspect.isfunction(own)}
    assert drawn == {name for name in WITH_A_PAGE if name.startswith("shockwave.pictures.")}


@pytest.mark.parametrize("name", [name for name in WITH_A_PAGE if name.count(".") > 1])
def test_other_names_with_a_page_exist_and_are_described(name: str) -> None:
    module, _, own = name.rpartition(".")
    assert inspect.getdoc(getattr(importlib.import_module(module), own))
