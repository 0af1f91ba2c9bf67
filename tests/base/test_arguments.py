"""Arguments that a constructor or a function does not take are errors of shockwave with the nearest name."""

import inspect
import pickle
from collections.abc import Callable
from typing import Any

import pytest
from attrs import frozen

import shockwave as sw
from shockwave.base.arguments import explain_arguments

#: Public classes that users construct.
CONSTRUCTED = [
    *(sw.Cell, sw.Chain, sw.Dashpot, sw.Exponential, sw.Impact, sw.KuwabaraKono, sw.Limit, sw.Material),
    *(sw.PowerContact, sw.PowerLaw, sw.Predictor, sw.Segment, sw.Shock, sw.Tabulated, sw.Taper, sw.Triangular),
    *(sw.Tsuji, sw.UniversalCurve, sw.Wall),
]


@pytest.mark.parametrize("make", CONSTRUCTED, ids=lambda make: make.__name__)
def test_a_misspelt_argument_is_an_error_that_names_the_nearest(make: Callable[..., object]) -> None:
    for name in inspect.signature(make).parameters:
        message = f"^{name}x: unknown argument .got '{name}x'; did you mean '{name}'"
        with pytest.raises(sw.InvalidValueError, match=message):
            make(**{f"{name}x": 1})


def test_arguments_of_plugin_profiles_are_explained_as_well() -> None:
    @frozen(kw_only=True)
    class Plain(sw.ShockProfile):
        duration_ratio: float = sw.quantity("", "n", above=1)
        rise = decay = sw.ShockProfile.force

    with pytest.raises(sw.InvalidValueError, match="did you mean 'duration_ratio'"):
        Plain(duration_ration=3)


def test_all_missing_arguments_are_reported() -> None:
    with pytest.raises(sw.InvalidValueError) as caught:
        sw.Material(youngs_modulus=1e9)  # type: ignore[call-arg]
    assert [fault.path for fault in caught.value.faults] == ["poisson_ratio", "density"]


FAULTY: dict[str, tuple[Callable[..., object], dict[str, Any], list[str]]] = {
    "chain": (
        sw.Chain,
        {"diameter": "3 kg", "granules": -1, "packing": "cubic"},
        ["material", "granules", "packing"],
    ),
    "misspelt": (sw.Chain, {"material": "ptfe", "diamter": 3, "gravity": -2}, ["diamter", "gravity"]),
    "shock": (
        sw.Shock,
        {"profile": "triangular", "duration_ratio": 0, "rise_time": "1 N"},
        ["duration_ratio", "rise_time"],
    ),
    "profile": (sw.PowerLaw, {"rise_exponent": -1, "decay_exponent": -3}, ["rise_exponent", "decay_exponent"]),
    "material": (
        sw.Material,
        {"youngs_modulus": -1, "poisson_ratio": 3, "density": 0},
        ["youngs_modulus", "poisson_ratio", "density"],
    ),
    "names": (sw.Segment, {"count": 0, "material": "nope"}, ["count", "material"]),
}


@pytest.mark.parametrize(("make", "values", "paths"), FAULTY.values(), ids=FAULTY)
def test_a_constructor_reports_all_wrong_values(
    make: Callable[..., object], values: dict[str, Any], paths: list[str]
) -> None:
    with pytest.raises(sw.InvalidValueError) as caught:
        make(**values)
    assert {fault.path for fault in caught.value.faults} >= set(paths)


def test_too_many_arguments_are_reported_with_the_names() -> None:
    with pytest.raises(
        sw.InvalidValueError, match=r"^arguments: .*too many positional arguments; known: times, forces"
    ):
        sw.Tabulated(*[(0, 1, 2)] * 9)  # type: ignore[arg-type]


def test_a_type_error_inside_a_function_stays_one() -> None:
    @explain_arguments
    def length(values: Any) -> int:
        return len(values)

    assert length([1, 2]) == 2
    with pytest.raises(TypeError, match="no len"):
        length(3)


def test_signatures_and_copies_are_those_of_the_class() -> None:
    assert [*inspect.signature(sw.Taper).parameters] == ["first", "last", "spacing"]
    taper = sw.Taper(first="2 mm", last="1 mm")
    assert pickle.loads(pickle.dumps(taper)) == taper
