"""Wrong scenarios: each ends in an error that names the place and the remedy, none in a traceback or a hang."""

from pathlib import Path

import pytest

from shockwave import __version__
from shockwave.base.errors import FileAccessError, ScenarioError
from shockwave.scenario.scenario import load_scenario
from support.scenario_texts import CHAIN, IMPACT, SHOCK, TABULATED, finite, schema_faults


def _chain(content: str) -> str:
    return f"chain: {{{content}}}\n{SHOCK}"


def _segments(content: str) -> str:
    return _chain(f"material: copper, radius: 1 mm, granules: {content}")


def _shock(old: str, new: str) -> str:
    return CHAIN + SHOCK.replace(old, new)


def _with(block: str) -> str:
    return CHAIN + SHOCK + block


ENDLESS = "material: copper, radius: 1 mm"
STEP = "simulate: {integrator: |%s}\n"
# text with a mark before the first fault, its path, a part of its problem
MARKED = {
    # keys
    "unknown-block": (_with("|predicts: {}"), "predicts", "did you mean 'predict'?"),
    "unknown-key": (
        _chain("material: copper, radius: 1, |diametr: 2"), "chain.diametr",
        "unknown key (got 'diametr'; did you mean 'diameter'? known: material, diameter, radius, granules, end, "
        "precompression, gravity, damping, packing, contact, elastic_only)",
    ),
    "parameter-of-none": (_shock("}", ", parameters: {|n: 1}}"), "shock.parameters.n", "no keys are allowed here"),
    "missing-size": ("|" + _chain("material: copper"), "chain.diameter", "or give radius"),
    "missing-density": (
        _chain("radius: 1, |material: {youngs_modulus: 1, poisson_ratio: 0}"), "chain.material.density", "<= 1e+30 kg",
    ),
    "both-sizes": (_chain("material: copper, |radius: 1, diameter: 2"), "chain.radius", "if diameter is"),
    # kinds and units
    "material-is-a-number": (_chain("material: |5, radius: 1"), "chain.material", "unknown material (got '5'"),
    "name-is-a-number": (_with("name: |12"), "name", "must be text (got 12; put it in quotes if it is text)"),
    "wrong-dimension": (_shock("1 us", "|15 kg"), "shock.rise_time", "must be a time, such as '15 us' (got '15 kg')"),
    "decimal-comma": (_chain("material: copper, diameter: |'9,5 mm'"), "chain.diameter", "a decimal point and no"),
    "decimal-comma-between-keys": (
        _chain("material: copper, diameter: 9,|5 mm"), "chain.'5 mm'", "a decimal point and no comma",
    ),
    "newer-version": (
        _with("version: |2"), "version",
        f"must be 1 for shockwave {__version__} (got 2; a newer shockwave may read it)",
    ),
    "version-true": (_with("version: |true"), "version", "must be 1 for"),
    "version-float": (_with("version: |1.0"), "version", "must be 1 for"),
    "nothing-for-a-number": (_shock(" 1 N", "| "), "shock.peak_force", "(got nothing)"),
    # ranges
    "negative-force": (_shock("1 N", "|-1 kN"), "shock.peak_force", "> 0 N (got '-1 kN')"),
    "incompressible": (
        _chain("radius: 1, material: {youngs_modulus: 1, poisson_ratio: |50 %, density: 1}"),
        "chain.material.poisson_ratio", "must be > -1 and < 0.5 (got '50 %')",
    ),
    "diameter-beyond-mass": (_chain("material: copper, diameter: |1e-200"), "chain.diameter", "a mass that"),
    "time-beyond-floats": (
        finite(", damping: {model: kuwabara-kono, time: |1e300}"), "chain.damping.time", "<= 1e+30 s",
    ),
    "mass-beyond-floats": (finite(", end: {wall: same, mass: |1.7e308}"), "chain.end.mass", "<= 1e+30 kg"),
    # names
    "unknown-material": (_chain("material: |coper, radius: 1"), "chain.material", "did you mean 'copper'?"),
    "unknown-profile": (_shock("triangular", "|triangle"), "shock.profile", "did you mean"),
    "unknown-coefficient": (
        _with("predict: {momentum_coefficient: |roughly}"), "predict.momentum_coefficient", "'exact', 'paper'",
    ),
    "rtol-of-a-prediction": (
        _with("predict: {|rtol: 1e-6}"), "predict.rtol",
        "unknown key (got 'rtol'; did you mean 'simulate.rtol'?)",
    ),
    "unknown-quadrature": (_with("predict: {quadrature: |tanh}"), "predict.quadrature", "did you mean 'tanh-sinh'?"),
    "not-installed": (_with("requires: [numpy, |no-such-distribution-1]"), "requires[1]", "must be an installed"),
    # records
    "record-of-nothing": (TABULATED.replace("par", "|par") % "", "shock.parameters.times", "or give file"),
    "file-and-times": (TABULATED % "times: [0, 1], |file: x.csv", "shock.parameters.file", "must be left out"),
    "times-backwards": (
        TABULATED % "times: [0, 2, |1], forces: [0, 1, 0]", "shock.parameters.times[2]", "must be greater than",
    ),
    "times-in-newtons": (
        TABULATED % "times: [0, |2 N, 3], forces: [0, 1, x]", "shock.parameters.times[1]", "must be a time",
    ),
    "file-above": (TABULATED % "file: |../../x.csv", "shock.parameters.file", "in the scenario's folder"),
    "file-through-a-link": (TABULATED % "file: |link/x.csv", "shock.parameters.file", "scenario's folder"),
    # segments
    "unknown-key-of-a-segment": (
        _segments("[{count: 2}, {|size: 1}]"), "chain.granules[1].size",
        "unknown key (got 'size'; known: count, material, diameter, radius, gap, contact, damping)",
    ),
    "both-sizes-of-a-segment": (
        _segments("[{diameter: 1, |radius: 1}]"), "chain.granules[0].radius", "must be left out if diameter is given",
    ),
    "taper-without-end": (_segments("[{|diameter: {from: 1 mm}}]"), "chain.granules[0].diameter.to", "must be given"),
    "taper-of-one": (
        _segments("[{count: |1, diameter: {from: 1 mm, to: 2 mm}}]"), "chain.granules[0].count", "must be >= 2 for a",
    ),
    "cell-without-repeat": (_segments("[|{cell: [{count: 1}]}]"), "chain.granules[0].repeat", "must be given"),
    "empty-cell": (_segments("[{repeat: 2, cell: |[]}]"), "chain.granules[0].cell", "one or more"),
    "error-in-a-cell": (
        _segments("[{repeat: 2, cell: [{count: 1}, {count: |0}]}]"), "chain.granules[0].cell[1].count", ">= 1",
    ),
    "no-segment": (_segments("|[]"), "chain.granules", "one or more segments"),
    "nothing-as-a-segment": (
        _segments("[{count: 4}, |null]"), "chain.granules[1]",
        "must be a mapping of count, material, diameter, radius, gap, contact, damping (got nothing)",
    ),
    "radius-from-a-diameter": (
        _segments("[{count: 4, diameter: |1e-12 m}]"), "chain.granules[0].diameter", "must be >= 1e-12 and <= 1e+06 m",
    ),
    "single-granule": (
        _segments("|[{count: 1}]"), "chain.granules",
        "must give a contact (got 1 granule; add granules, a wall or a striker)",
    ),
    # ends
    "end-of-text": (finite(", end: |wall"), "chain.end", "must be free, or a mapping of wall, mass, stiffness, damp"),
    "free-end-with-stiffness": (finite(", |end: {stiffness: 1}"), "chain.end.wall", "must be given"),
    "stiff-fixed-wall": (
        finite(", end: {wall: same, stiffness: |1e6 N/m}"), "chain.end.stiffness",
        "must be left out for a fixed wall (got 1e+06; give the mass of the wall)",
    ),
    "unknown-wall": (finite(", end: {wall: |rigidd}"), "chain.end.wall", "unknown material (got 'rigidd'"),
    "wall-of-an-endless-chain": (
        _chain(f"{ENDLESS}, end: |{{wall: same}}"), "chain.end",
        "must be left out for an endless chain (give the number of granules)",
    ),
    "stiff-endless-chain": (
        _chain(f"{ENDLESS}, contact: {{exponent: |6.5, stiffness: 1}}"), "chain.contact.exponent",
        "must be >= 1.05 and <= 6 for the waves of an endless chain (got 6.5; give the number of granules)",
    ),
    "gravity-without-a-wall": (
        finite(", gravity: |9.81 m/s**2"), "chain.gravity",
        "must be 0 for a chain with a free end (got 9.81; give a wall as end)",
    ),
    "gap-under-precompression": (
        _segments("[{count: 4, gap: |1 um}], precompression: 1 N"), "chain.granules[0].gap",
        "must be 0 under precompression",
    ),
    "too-many": (
        _segments("|5000000, end: {wall: same}"), "chain.granules", "must be <= 1000000 for a chain with end",
    ),
    # contact laws
    "damping-without-model": (finite(", |damping: {time: 1 us}"), "chain.damping.model", "must be given"),
    "law-as-damping": (
        finite(", damping: {model: |hertz}"), "chain.damping.model",
        "must be kuwabara-kono, dashpot or tsuji (got 'hertz')",
    ),
    "parameter-of-another-damping": (
        finite(", damping: {model: dashpot, coefficient: 1, |time: 1 us}"), "chain.damping.time",
        "unknown key (got 'time'; known: model, coefficient)",
    ),
    "tsuji-without-hertz": (
        finite(", damping: {model: |tsuji, restitution: 0.9}, contact: {exponent: 2, stiffness: 1}"),
        "chain.damping.model", "must be dashpot or kuwabara-kono for a contact exponent other than 1.5",
    ),
    "contact-without-stiffness": (finite(", |contact: {exponent: 2}"), "chain.contact.stiffness", "must be given"),
    "contact-as-text": (finite(", contact: |hertz"), "chain.contact", "must be a mapping such as {model: hertz}"),
    "contact-without-name": (finite(", contact: {model:| }"), "chain.contact.model", "must be text (got nothing)"),
    "law-of-nothing": (
        finite(", |contact: {}"), "chain.contact.exponent",
        "must be given (got nothing; exponent p of F = k d^p, >= 1 and <= 10; or give model)",
    ),
    "elastic-plastic-endless-chain": (
        _chain(f"{ENDLESS}, contact: |{{model: elastic-plastic}}"), "chain.contact",
        "must be left out for an endless chain (give the number of granules)",
    ),
    "elastic-plastic-with-damping": (
        finite(", contact: {model: elastic-plastic}, damping: |{model: dashpot, coefficient: 1}"), "chain.damping",
        "must be left out for the contact law elastic-plastic",
    ),
    "elastic-plastic-segment-with-damping": (
        _segments("[{contact: |{model: elastic-plastic}}, {}], damping: {model: dashpot, coefficient: 1}"),
        "chain.granules[0].contact", "(or damping: {model: dashpot, coefficient: 0} for this segment)",
    ),
    "elastic-plastic-chain-that-must-be-elastic": (
        finite(", contact: {model: elastic-plastic}, elastic_only: |true"), "chain.elastic_only",
        "must be left out for elastic-plastic contacts",
    ),
    "elastic-plastic-packing": (
        _segments("4, contact: {model: elastic-plastic}, packing: |hexagonal"), "chain.packing",
        "must be left out for a chain with further features",
    ),
    "elastic-plastic-contact-that-is-too-soft": (
        finite(", contact: |{model: elastic-plastic}, end: {wall: rigid}"), "chain.contact",
        "at contact 3, between granule 3 (copper) and the wall (rigid)",
    ),
    "elastic-plastic-contact-of-a-segment-that-is-too-hard": (
        _segments("[{material: stainless-steel-302, contact: |{model: elastic-plastic}}, {material: homalite-100}]"),
        "chain.granules[0].contact", "at contact 0, between granule 0 (stainless-steel-302) and granule 1 (homalite-1",
    ),
    "tsuji-of-a-segment-without-hertz": (
        _segments("[{}, {damping: {model: |tsuji, restitution: 0.9}}], contact: {exponent: 2, stiffness: 1}"),
        "chain.granules[1].damping.model", "must be dashpot or kuwabara-kono for a contact exponent other than 1.5",
    ),
    "unit-of-a-stiffness": (
        finite(", contact: {exponent: 2, stiffness: |5e7 N/m}"), "chain.contact.stiffness",
        "must be a bare number, in N/m^p (got '5e7 N/m')",
    ),
    # excitations
    "shock-and-impact": (finite() + f"|{IMPACT}", "impact", "must be left out if shock is given"),
    "neither": ("|" + finite("", ""), "shock", "must be given (got nothing; a mapping of profile"),
    "impact-without-velocity": (finite("", "|impact: {diameter: 1 mm}\n"), "impact.velocity", "must be given"),
    "impact-on-an-endless-chain": (
        "|" + CHAIN + IMPACT, "chain.granules", "must be given, because a striker needs a finite chain",
    ),
    # options
    "contact-beyond-the-wall": (
        finite(", end: {wall: same}") + "simulate: {contacts: ['3', |'4']}\n", "simulate.contacts[1]",
        "must be at most 3, the last contact of this chain (got 4)",
    ),
    "integrator-that-ends-no-steps-at-flow": (
        finite(", contact: {model: elastic-plastic}") + STEP % "radau", "simulate.integrator",
        "must be rkn64, rkn86, rkn1210, verlet, pefrl, rk4 or dop853 for elastic-plastic contacts",
    ),
    "integrator-without-damping": (
        finite(", damping: {model: dashpot, coefficient: 1}") + STEP % "rkn86", "simulate.integrator",
        "must be dop853 for a chain with damping",
    ),
    "integrator-without-damping-of-a-wall": (
        finite(", end: {wall: same, mass: 2 kg, damping: 50 N*s/m}") + STEP % "rkn86", "simulate.integrator",
        "must be dop853 for a chain with damping",
    ),
    "integrator-without-the-motion-of-a-bar": (
        finite(", end: {bar: {material: brass-260, diameter: 1 cm}}") + STEP % "rkn86", "simulate.integrator",
        "must be dop853 for a chain with damping, a dashpot or a bar at its end,",
    ),
    "interval-without-record": (
        finite() + "simulate: {interval: |1 us}\n", "simulate.interval",
        "must be left out without record or sensors (got 1e-06 s; list what to record)",
    ),
    "sweep-of-a-missing-segment": (
        finite() + "sweep: {grid: {|'chain.granules[3].radius': [1, 2]}}\n", "sweep.grid.'chain.granules[3].radius'",
        "did you mean 'chain.granules[0].radius'?",
    ),
}  # fmt: skip
#: Errors that a schema sees: not those of missing keys, of values that exclude each other, or of files.
SEEN = {
    *("unknown-block", "unknown-key", "parameter-of-none", "material-is-a-number", "name-is-a-number"),
    *("decimal-comma-between-keys", "newer-version", "version-true", "nothing-for-a-number", "mass-beyond-floats"),
    *("time-beyond-floats", "unknown-material", "unknown-profile", "rtol-of-a-prediction", "unknown-quadrature"),
    *("times-in-newtons", "unknown-key-of-a-segment", "empty-cell", "error-in-a-cell", "no-segment"),
    *("nothing-as-a-segment", "end-of-text", "unknown-wall", "law-as-damping", "parameter-of-another-damping"),
    *("contact-as-text", "contact-without-name"),
}


@pytest.mark.parametrize("name", MARKED)
def test_a_wrong_scenario_is_refused_in_its_place(tmp_path: Path, name: str) -> None:
    marked, where, part = MARKED[name]
    before, _, behind = marked.partition("|")
    (tmp_path / "link").symlink_to("/usr")
    path = tmp_path / "bad.yaml"
    path.write_text(before + behind, encoding="utf-8", newline="")
    with pytest.raises((ScenarioError, FileAccessError)) as caught:
        load_scenario(path)
    first = str(caught.value).split("\n")[0]
    place = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
    assert first.startswith(f"{path}:{place}: {where}: ")
    assert part in first
    assert bool(schema_faults(before + behind)) is (name in SEEN)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (CHAIN + "striker: {velocity: 1}\n", "striker: unknown key (got 'striker'; did you mean 'impact'?"),
        (_chain(f"{ENDLESS}, beads: 5"), "chain.beads: unknown key (got 'beads'; did you mean 'granules'?"),
        (_chain(f"{ENDLESS}, mass: 1 g"), "chain.mass: unknown key (got 'mass'; give density"),
        (
            _with("sweep: {grid: {chain.contact.model: [hertz, elastic-plastic]}}"),
            "the model of a block cannot be varied",
        ),
    ],
    ids=["striker", "beads", "mass", "model"],
)
def test_another_word_for_a_key_is_answered_with_the_key(tmp_path: Path, text: str, hint: str) -> None:
    (tmp_path / "words.yaml").write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(tmp_path / "words.yaml")
    assert hint in str(caught.value)


TOGETHER = {
    "equal granules": (
        "shock:\n"
        "  profile: power-law\n"
        "  peak_force: |15 kg\n"
        "  rise_time: 15 us\n"
        "  duration_ratio: |0.5\n"
        "  parameters: {rise_exponent: |-1, decay_exponent: 5, |extra: 1}\n"
        "|chain:\n"
        "  |diametr: 9.5 mm\n"
        "  |material: {youngs_modulus: |.inf, poisson_ratio: 0.3}\n"
        "predict: {model: |section-5, alpha: |none, quadrature: |none, equal_tolerance: |2}\n"
        "simulate: {integrator: |none, rtol: |1}\n"
        "|predict: {}\n"
        "sweep: |{}\n",
        "shock.peak_force shock.duration_ratio shock.parameters.rise_exponent shock.parameters.extra chain.diameter "
        "chain.diametr chain.material.density chain.material.youngs_modulus predict.model predict.alpha "
        "predict.quadrature predict.equal_tolerance simulate.integrator simulate.rtol predict sweep",
    ),
    "segments": (
        "chain:\n"
        "  material: copper\n"
        "  diameter: |1 kg\n"
        "  granules:\n"
        "    - {count: |0, material: |no}\n"
        "    - {repeat: 2, cell: [{gap: |-1}]}\n"
        "  end: {wall: |no, mass: |0}\n"
        "  precompression: |-1\n"
        "  |damping: {model: tsuji}\n"
        "impact: {velocity: |1 m, |size: 2}\n",
        "chain.diameter chain.granules[0].count chain.granules[0].material chain.granules[1].cell[0].gap "
        "chain.end.wall chain.end.mass chain.precompression chain.damping.restitution impact.velocity impact.size",
    ),
    "combinations": (
        "chain: {material: copper, diameter: 5 mm, granules: 9, precompression: |2 N, damping: {model: dashpot,"
        " coefficient: 1}}\n"
        "motion: {velocity: 1 m/s, until: 1 us}\n"
        "simulate: {contacts: [0, |99], sensors: [|wall, {contact: |99}], integrator: |rkn86}\n"
        "limit: {force: 1 N, at: |spring}\n",
        "chain.precompression simulate.contacts[1] simulate.sensors[0] simulate.sensors[1].contact simulate.integrator "
        "limit.at",
    ),
}


@pytest.mark.parametrize("name", TOGETHER)
def test_all_faults_are_reported_together_in_the_order_of_the_file(tmp_path: Path, name: str) -> None:
    marked, paths = TOGETHER[name]
    path = tmp_path / "bad.yaml"
    path.write_text(marked.replace("|", ""))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    lines = [(number, line.split("|")) for number, line in enumerate(marked.splitlines(), start=1)]
    places = [
        f"{path}:{number}:{len(''.join(parts[:end])) + 1}" for number, parts in lines for end in range(1, len(parts))
    ]
    assert [(fault.location, fault.path) for fault in caught.value.faults] == list(
        zip(places, paths.split(), strict=True)
    )


def test_a_damping_without_a_name_has_one_error(tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(finite(", damping: {time: 1 us}"))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(tmp_path / "bad.yaml")
    assert [fault.path for fault in caught.value.faults] == ["chain.damping.model"]


def test_faults_of_a_record_file_keep_its_lines_and_those_of_the_scenario_theirs(tmp_path: Path) -> None:
    (tmp_path / "pulse.csv").write_text("t [s],f [N]\n0,0\n2,1\n1,0\n")
    path = tmp_path / "bad.yaml"
    path.write_text("chain: {radius: 1, material: no}\nshock: {profile: tabulated, parameters: {file: pulse.csv}}")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert [fault.location for fault in caught.value.faults] == [f"{path}:1:30", f"{tmp_path / 'pulse.csv'}:4"]


def test_a_long_line_of_a_record_file_is_reported_in_that_file(tmp_path: Path) -> None:
    (tmp_path / "pulse.csv").write_text("t [s],f [N]\n0,0\n" + "1" * 20_000)
    path = tmp_path / "bad.yaml"
    path.write_text(CHAIN + "shock: {profile: tabulated, parameters: {file: pulse.csv}}")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert [(fault.location, fault.path) for fault in caught.value.faults] == [(str(tmp_path / "pulse.csv"), "")]


def test_messages_use_the_given_name_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text("x: 1\n")
    with pytest.raises(ScenarioError, match=r"^\./bad\.yaml:1:1: "):
        load_scenario("./bad.yaml")


def test_wrong_samples_of_a_column_are_one_error_that_states_their_number(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(TABULATED % f"times: [0, {'1 US, ' * 500}], forces: [0, 1, x]")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    (times, forces) = caught.value.faults
    assert times.path == "shock.parameters.times[1]"
    assert times.problem.endswith("(got '1 US'; unknown unit; did you mean 'us'?; one of 500)")
    assert forces.problem.endswith("(got 'x')")


def test_a_long_list_of_errors_is_shortened(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(CHAIN + SHOCK + f"sweep: {{grid: {{shock.rise_time: [{'x,' * 500}]}}}}")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert len(caught.value.faults) == 101
    assert str(caught.value.faults[-1]).endswith("more errors")
