"""Arguments of the functions of the compiled modules: what does not fit raises an exception, and nothing crashes."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from itertools import product
from typing import Any
from unittest.mock import Mock, patch

import numpy as np
import pytest

import shockwave as sw
from shockwave.base.errors import NumericalError, PluginError
from shockwave.engine import backend
from shockwave.engine.chain_motion import integrate
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import SearchRequest
from shockwave.engine.wave_search import find_primaries
from shockwave.profiles.free_path import FreePath, tabulate_powers
from shockwave.simulation.whole_chain import WholeChain
from support.assemblies import uniform
from support.scenes import POWER

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(backend.compiled is None, reason=backend.lack()),
]

PROBLEM = ScaledProblem(POWER, 2.0, 1.0)
RUN = "method rows coefficients stops times WATCHED IMPULSES SETTINGS TABLE SAMPLES PLASTIC curves"
RUN += " RECORD STATES PEAKS LAST expired"
#: Arguments by function. Buffers come first; those that are written to are in capitals.
ARGUMENTS = {
    "primary": "method jobs rows coefficients stops WANTED FOUND lanes expired",
    "read": "times states WAVE",
    "run": RUN,
    "run with a record": RUN,
}
OTHERS = {"lanes", "expired"}
#: Functions and places of their buffers.
BUFFERS = [(name, at) for name, text in ARGUMENTS.items() for at, each in enumerate(text.split()) if each not in OTHERS]


def function(name: str) -> Callable[..., Any]:
    name = name.split()[0]
    module = "_chains" if name == "run" else "_lanes"
    return getattr(import_module(f"shockwave.engine.{module}"), name)  # type: ignore[no-any-return]


def at_once() -> bool:
    """Whether the time has expired: at the first question, so that no wrong number makes a call last."""
    return True


def arguments(name: str) -> list[Any]:
    """Copies of valid arguments."""
    copies = [np.array(each) if isinstance(each, np.ndarray | array) else each for each in valid(name)]
    return [at_once if callable(each) else each for each in copies]


@cache
def valid(name: str) -> tuple[Any, ...]:
    """Valid arguments: of `run` for a damped chain, of `read` for three states, of the others for case A."""
    compiled = Mock()
    if name == "primary":
        find_primaries([SearchRequest(PROBLEM, 1e-6, 1e-6, (9,))], Rkn86, compiled)
    elif name == "run with a record":
        # nothing has been computed
        with patch.dict(sys.modules, {"shockwave.engine._chains": compiled}), pytest.raises(NumericalError):
            WholeChain(PROBLEM, Rkn86(compiled=compiled)).advance(1.0)
    elif name == "run":
        with pytest.raises(NumericalError):
            integrate(uniform(12, damping=np.full(12, 0.1)), 1e-6, until=20.0, times=(5.0, 10.0), compiled=compiled)
    else:
        compiled.read(np.arange(3.0), np.zeros((2, 3, 4)), np.zeros(9))
    given: tuple[Any, ...] = getattr(compiled, name.split()[0]).call_args.args
    return given


def test_the_layout_of_the_arguments_is_that_of_the_test() -> None:
    for name, text in ARGUMENTS.items():
        given = arguments(name)
        assert [isinstance(each, np.ndarray) for each in given] == [each not in OTHERS for each in text.split()]
        function(name)(*given)


# ---------------------------------------------------------------- arguments that do not fit


def of_zeros(dtype: Any) -> Callable[[Any], Any]:
    return lambda buffer: np.zeros(buffer.shape, dtype)


def unaligned(buffer: Any) -> Any:
    return np.frombuffer(bytearray(buffer.nbytes + 1), np.uint8)[1:].view(buffer.dtype)


TYPES: dict[str, Callable[[Any], Any]] = {
    "none": lambda _: None,
    "number": lambda _: 1.0,
    "list": lambda buffer: buffer.tolist(),
    "bytes": lambda buffer: bytes(buffer.nbytes),
    "float32": of_zeros(np.float32),
    "swapped": of_zeros(np.dtype(float).newbyteorder()),
    "objects": of_zeros(object),
    "strided": lambda buffer: np.repeat(buffer, 2, axis=-1)[..., ::2],
    "unaligned": unaligned,
    "records": of_zeros([("time", "f8"), ("force", "f8")]),
}


@pytest.mark.parametrize("kind", TYPES)
def test_buffers_of_another_type_are_refused(kind: str) -> None:
    for name, index in BUFFERS:
        given = arguments(name)
        if given[index].size == 0:
            continue  # nothing is read or written
        given[index] = TYPES[kind](given[index])
        with pytest.raises((TypeError, ValueError, BufferError)):
            function(name)(*given)


def test_buffers_that_are_written_to_must_be_writable() -> None:
    for name, index in BUFFERS:
        if ARGUMENTS[name].split()[index].isupper():
            given = arguments(name)
            given[index].flags.writeable = False
            with pytest.raises((ValueError, BufferError)):
                function(name)(*given)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_another_number_of_arguments_is_refused(name: str) -> None:
    given = arguments(name)
    for wrong in (given[:-1], [*given, 1.0], []):
        with pytest.raises(TypeError, match=rf"^{name.split()[0]} takes {len(given)} arguments$"):
            function(name)(*wrong)


# Changes of the arguments that must be refused. The last columns of a job are: first piece, number of pieces, first
# coefficient, first stop, first requested contact and number of these.
MISFITS = {
    "short-method": ("primary", "a[0] = a[0][:-1].copy()"),
    "method-of-100-stages": ("primary", "a[0][0] = 100"),
    "piece": ("primary", "a[1][-6] = 1e6"),
    "pieces": ("primary", "a[1][-5] = 1e9"),
    "begin-of-terms": ("primary", "a[2][0, 2] = 1e9"),
    "number-of-terms": ("primary", "a[2][:, 3] = 1e5"),
    "run-with-many-terms": ("run", "a[1][:, 3] = 1e5"),
    "stop": ("primary", "a[1][-3] = 1e7"),
    "stops-before-the-end": ("primary", "a[4][-1] = 1.0"),
    "half-a-granule": ("primary", "a[1][3] = 0.5"),
    "lanes": ("primary", "a[7] = 3"),
    "no-lanes": ("primary", "a[7] = None"),
    "record-of-few-numbers": ("run with a record", "a[12] = a[12][:-1].copy()"),
    "record-of-many-peaks": ("run with a record", "a[12][4] = 1e9"),
    "record-of-states-before-the-run": ("run with a record", "a[12][5] = 1"),
    "record-of-half-a-state": ("run with a record", "a[13] = a[13][:, :-1].copy()"),
    "record-with-short-peaks": (
        "run with a record",
        "a[14] = np.zeros(len(a[14]), [('contact', 'i8'), ('time', 'f8')])",
    ),
    "record-of-few-contacts": ("run with a record", "a[15] = a[15][:4].copy()"),
    "record-of-a-peak-beyond-the-log": ("run with a record", "a[15][-1] = 10**6"),
    "reading-of-one-state": ("read", "a[0], a[1] = a[0][:1].copy(), a[1][:, :1].copy()"),
    "reading-of-short-states": ("read", "a[1] = a[1][:, :-1].copy()"),
    "run-without-coefficients": ("run", "a[2] = a[2][:0]"),
    "run-with-a-watched-contact-beyond-the-chain": ("run", "a[5][1] = 12"),
    "run-with-rows-in-descending-order": ("run", "a[5][2:] = a[5][2:][::-1].copy()"),
    "run-with-few-impulses": ("run", "a[6] = a[6][:-1].copy()"),
    "run-with-few-samples": ("run", "a[9] = a[9][:-1].copy()"),
    "run-with-few-settings": ("run", "a[7] = a[7][:-1].copy()"),
    "run-of-many-contacts": ("run", "a[7][7] = 1e6"),
    "run-with-a-negative-margin": ("run", "a[7][18] = -1e6"),
}


@pytest.mark.parametrize("misfit", MISFITS)
def test_arguments_that_do_not_fit_one_another_are_refused(misfit: str) -> None:
    name, change = MISFITS[misfit]
    a = arguments(name)
    exec(change)
    with pytest.raises((ValueError, TypeError)):
        function(name)(*a)


def numbers(name: str) -> Iterator[tuple[int, int]]:
    """Places in the buffers of a function, about 200 of each."""
    for index, buffer in enumerate(arguments(name)):
        if isinstance(buffer, np.ndarray) and buffer.dtype.names is None:
            yield from product([index], range(0, buffer.size, buffer.size // 100 + 1))


def call(name: str, given: list[Any]) -> None:
    """Call the function; that it refuses the arguments is as good as that it returns."""
    with suppress(ValueError):
        function(name)(*given)


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -1.0, -1e18, 0.5, 1e18, 1e300], ids=str)
@pytest.mark.parametrize("name", ARGUMENTS)
def test_no_number_in_a_buffer_makes_the_code_crash(name: str, wrong: float) -> None:
    for index, place in numbers(name):
        given = arguments(name)
        given[index].flat[place] = np.array(wrong).astype(given[index].dtype)
        call(name, given)


@pytest.mark.parametrize("size", [-8, -2, -1, 1, 2, 8])
def test_no_size_of_a_buffer_makes_the_code_crash(size: int) -> None:
    for name, index in BUFFERS:
        given = arguments(name)
        given[index] = np.resize(given[index], max(given[index].size + size, 0))
        call(name, given)


@pytest.mark.parametrize("wrong", ["count", "float32"])
def test_the_wrong_table_of_a_plugin_is_refused(wrong: str) -> None:
    table = tabulate_powers(1.0, 1.0, 3.0)
    rows = table.rows.astype(np.float32 if wrong == "float32" else float)
    if wrong == "count":  # of the coefficients of the last piece
        rows[-1, 3] = 1e5

    class Plugin(sw.Triangular):
        def closed_free_path(self) -> FreePath:
            return FreePath(rows, table.coefficients, table.error)

    with pytest.raises(PluginError, match=r"Plugin: closed_free_path\(\) must return a FreePath"):
        sw.Shock(profile=Plugin(duration_ratio=3.0), peak_force=1.0, rise_time=1.0)
