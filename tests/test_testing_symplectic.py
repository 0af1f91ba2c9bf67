"""The test kit for plugins finds methods that say they are symplectic and are not, and those that are and do not."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

from selection import keeping
from shockwave.quadrature import FloatArray
from shockwave.simulation.nystroem import Rkn1210
from shockwave.simulation.one_step import Attempt, OneStep
from shockwave.simulation.verlet import Verlet
from shockwave.testing import IntegratorContract
from test_testing_broken import _nothing_known  # noqa: F401
from test_testing_methods import other


class BogackiShampine(OneStep):
    """Bogacki & Shampine (1989), doi:10.1016/0893-9659(89)90079-7: order 3 with an error estimate of order 2."""

    name: ClassVar[str] = "bogacki-shampine"
    order: ClassVar[int] = 3
    error_order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = True
    symplectic: ClassVar[bool] = False

    def attempt(self, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
        def slope(share: float, x: FloatArray, v: FloatArray) -> FloatArray:
            return np.array((v, acceleration(time + share * size, x)))

        state = np.array((x, v))
        first = np.array((v, a))
        second = slope(1 / 2, *(state + size / 2 * first))
        third = slope(3 / 4, *(state + 3 / 4 * size * second))
        new = state + size * (2 * first + 3 * second + 4 * third) / 9
        last = slope(1, *new)
        error = np.abs(size * (-5 / 72 * first + second / 12 + third / 9 - last / 8)).max(axis=(0, 1))
        return Attempt(new[0], new[1], last[1], error)


class Ruth3(OneStep):
    """Ruth (1983), doi:10.1109/TNS.1983.4332919: kicks and drifts of order 3."""

    name: ClassVar[str] = "ruth-3"
    order: ClassVar[int] = 3
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = True

    def attempt(self, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
        passed = 0.0
        for kick, drift in ((7 / 24, 2 / 3), (3 / 4, -2 / 3), (-1 / 24, 1)):
            v = v + kick * size * acceleration(time + passed * size, x)
            x = x + drift * size * v
            passed += drift
        return Attempt(x, v, acceleration(time + size, x), 0.0 * np.asarray(size))


@pytest.mark.parametrize(
    ("base", "declared", "does"),
    [
        (BogackiShampine, True, "does not keep"),
        (Rkn1210, True, "does not keep"),
        (Ruth3, False, "keeps"),
        (Verlet, False, "keeps"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_wrong_word_about_the_symplectic_form_is_found(base: type[Any], declared: bool, does: str) -> None:
    message = (
        rf"symplectic is {declared}, and a step {does} the symplectic\s+form: .*write  symplectic = {not declared}"
    )
    with pytest.raises(pytest.fail.Exception, match=f"(?s){message}"):
        IntegratorContract().test_clause_1_symplectic_is_true(other(base, symplectic=declared))


@pytest.mark.parametrize("method", keeping([BogackiShampine, Ruth3], Ruth3))
def test_the_true_word_about_it_is_not(method: type[Any]) -> None:
    IntegratorContract().test_clause_1_symplectic_is_true(method)
