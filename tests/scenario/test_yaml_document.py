"""The document reader: text to plain data, with places and limits."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from shockwave.base.errors import Fault, ScenarioError
from shockwave.scenario.yaml_document import parse_document, read_document

NESTED = """\
# a comment
first: 1
block:
  inner: [10, {deep: yes}]
  "quoted key": text
list:
  - a
  - b
"""


def _faults(text: str) -> list[str]:
    try:
        faults: Sequence[Fault] = parse_document(text, "f").faults
    except ScenarioError as error:
        faults = error.faults
    return [str(fault) for fault in faults]


SCALARS = [
    ("1", 1), ("-12", -12), ("+3", 3), ("010", 10), ("1e-5", 1e-5), ("1E3", 1000.0), (".5", 0.5), ("2.", 2.0),
    ("null", None), ("~", None), ("", None), ("true", True), ("False", False), ("yes", "yes"), ("off", "off"),
    ("2001-01-01", "2001-01-01"), ("1:30", "1:30"), ("1_000", "1_000"), ("0x1F", "0x1F"), (".inf", ".inf"),
    ("1 N", "1 N"), ('"1"', "1"), ("'true'", "true"), (r'"a\u00b5"', "aµ"), ("=", "="), ("1e999", float("inf")),
    ("9" * 5000, float("inf")),
]  # fmt: skip


@pytest.mark.parametrize(("text", "value"), SCALARS, ids=[text[:20] for text, _ in SCALARS])
def test_scalars_are_text_decimal_numbers_truth_values_and_null(text: str, value: object) -> None:
    found = parse_document(f"key: {text}\n", "f").data["key"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("path", "key", "place"),
    [
        ((), False, "f:2:1"),
        (("first",), False, "f:2:8"),
        (("block", "inner", 1, "deep"), False, "f:4:22"),
        (("block", "inner", 1, "deep"), True, "f:4:16"),
        (("block", "quoted key"), True, "f:5:3"),
        (("list", 1), False, "f:8:5"),
        (("list", 7), False, "f:6:1"),
        (("block", "missing", "deeper"), True, "f:3:1"),
    ],
)
def test_faults_have_the_place_of_the_value_or_of_the_nearest_above(
    path: tuple[str | int, ...], key: bool, place: str
) -> None:
    assert parse_document(NESTED, "f").place(Fault(path, "", at_key=key)).location == place


def test_carriage_returns_and_a_byte_order_mark_do_not_shift_places() -> None:
    document = parse_document("\ufeffa: 1\r\nb:\r\n  c: 2\r\n", "f")
    assert document.data == {"a": 1, "b": {"c": 2}}
    assert document.place(Fault(("b", "c"), "")).location == "f:3:6"


REFUSED = {
    "duplicate": ("a: 1\na: 2", ["f:2:1: a: must be given once"]),
    "anchor": ("a: &x 1\nb: *x", ["f:1:4: must be YAML (got: an anchor, an alias or a tag"]),
    "tag": ("a: !!python/name:os.system x", ["f:1:4: must be YAML (got: an anchor, an alias"]),
    "billion-laughs": ("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]", ["f:1:4: must be YAML (got: an anchor, an alias"]),
    "several": ("a: 1\na: 2\n1: x\n~: z", ["f:2:1", "f:3:1: must have names as keys (got '1'", "f:4:1"]),
    "collections-as-keys": ("? [a, b]\n: 1\n? {c: d}\n: 2", ["f:1:3: ", "f:3:3: "]),
    "two-documents": ("a: 1\n---\nb: 2", ["f:2:1: must be YAML (got: found another document; put each scenario"]),
    "list": ("- 1", ["f:1:1: must be a mapping"]),
    "nothing": ("# nothing\n", ["f:1:1: must be a mapping"]),
    "colon": ("a: b: c", ["f:1:5: must be YAML (got: mapping values are not allowed here; indent"]),
    "brackets": (
        "a: [sensors[0].peak]",
        ["f:1:12: must be YAML (got: expected ',' or ']', but got '['; put text that holds brackets in quotes"],
    ),
    "at-sign": ("a: @home", ["f:1:4: must be YAML (got: found character '@' that cannot start any"]),
    "tab": ("a:\n\tb: 1\n", ["f:2:1: must be YAML (got: found character '\\t' that cannot start any token; use"]),
    "open-quote": ("a: 1\nb: 'open", ["f:2:9: must be YAML"]),
    "control": ("a: 1\nb: \x07", ["f:2:4: must be printable text (got the character U+0007"]),
    "escaped-control": (r'a: "\u001b[31m"', ["f:1:4: a: must be printable text"]),
    "surrogate": (r'a: "\ud800"', ["f:1:4: a: must be printable text"]),
    "escape-beyond-unicode": (r'a: "\Uffffffff"', ["f:1:7: must be YAML"]),
    "line-separator": ("a: 1\u2028b: 2", ["f:1:5: must be printable"]),
}


@pytest.mark.parametrize("name", REFUSED)
def test_other_text_is_a_fault_in_its_place(name: str) -> None:
    text, faults = REFUSED[name]
    for fault, beginning in zip(_faults(text), faults, strict=True):
        assert fault.startswith(beginning)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("[" * 1100, "nest fewer levels"),
        ("a: " + "[" * 200 + "]" * 200, "must have at most 50 nested levels"),
        ("? " + "{b: " * 200 + "}" * 200 + "\n: 1", "must have names as keys (got a list or a mapping; "),
        ("a: [" + "1," * 100_001 + "]", "more than 100000 values"),
    ],
)
def test_hostile_documents_end_in_a_fault(text: str, part: str) -> None:
    (fault,) = _faults(text)
    assert part in fault


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"a: 1\nb: \xb5\n", r"any.yaml:2:4: must be UTF-8 text \(got the byte 0xb5; save the file as UTF-8\)"),
        (b"a: 1\n" * 420_000, r"any.yaml:1:1: must be at most 1 MiB \(got more; put a long record into a CSV file"),
    ],
    ids=["latin", "two-mebibytes"],
)
def test_files_without_a_scenario_are_refused(tmp_path: Path, data: bytes, message: str) -> None:
    (tmp_path / "any.yaml").write_bytes(data)
    with pytest.raises(ScenarioError, match=message):
        read_document(tmp_path / "any.yaml")
