"""Shapes: exponents, rates and duration ratios at the ends of their ranges."""

from __future__ import annotations

from shockwave.benchmark.stress.case import Case
from shockwave.benchmark.stress.checks import AT_DEFAULT, by_method, like, refused
from shockwave.benchmark.stress.scenes import Make, exponential, power, record
from shockwave.errors import InvalidValueError

__all__ = ["CASES"]

_THEME = "shapes"
_OTHER_METHOD = "the peak force of DOP853 to 2e-6"
# Rise time over the natural time, and n: long enough for a train.
_RISE, _RATIO = 2.0, 3.0


def _exponents() -> list[Case]:
    made: list[tuple[str, str, Make]] = []
    for exponent in (1e-8, 1e-5, 1e-3, 50.0):
        rise, decay = power(exponent, 1.0, _RATIO, _RISE), power(1.0, exponent, _RATIO, _RISE)
        made.append((f"rise-exponent-{exponent:g}", f"power law, eta1 {exponent:g}, eta2 1", rise))
        made.append((f"decay-exponent-{exponent:g}", f"power law, eta1 1, eta2 {exponent:g}", decay))
    made.append(("exponents-1e6", "power law, eta1 and eta2 1e6", power(1e6, 1e6, _RATIO, _RISE)))
    return [_by_method(*parts) for parts in made]


def _rates() -> list[Case]:
    made: list[tuple[str, str, Make]] = []
    for rate in (700.0, 1e4):
        rise, decay = exponential(rate, 1.0, _RATIO, _RISE), exponential(1.0, rate, _RATIO, _RISE)
        made.append((f"rise-rate-{rate:g}", f"exponential, k1 {rate:g}, k2 1", rise))
        made.append((f"decay-rate-{rate:g}", f"exponential, k1 1, k2 {rate:g}", decay))
    made.append(("rates-minus-700", "exponential, k1 and k2 -700", exponential(-700.0, -700.0, _RATIO, _RISE)))
    return [_by_method(*parts) for parts in made]


def _by_method(name: str, asked: str, make: Make) -> Case:
    return Case(name=name, theme=_THEME, asked=asked, must=_OTHER_METHOD, check=by_method(make))


def _no_rates() -> Case:
    vanishing, straight = exponential(1e-12, 1e-12, _RATIO, _RISE), power(1.0, 1.0, _RATIO, _RISE)
    return Case(
        name="rates-1e-12",
        theme=_THEME,
        asked="exponential, k1 and k2 1e-12",
        must="the answers for a triangle to 1e-10: of formulae, and of a table fitted to the force",
        check=like(vanishing, straight, 1e-10),
    )


def _ratios() -> list[Case]:
    cases = []
    for ratio, name in ((1 + 1e-9, "1+1e-9"), (1.0001, "1.0001"), (1e4, "1e4")):
        rise_time = 6.0 / ratio
        cases.append(
            Case(
                name=f"duration-ratio-{name}",
                theme=_THEME,
                asked=f"triangle of 6 natural times, n {name}",
                must="the answers for the same three points as a record, to 2e-6",
                check=like(
                    power(1.0, 1.0, ratio, rise_time), record([0, rise_time, ratio * rise_time], [0, 1, 0]), AT_DEFAULT
                ),
            )
        )
    return cases


CASES = (
    *_exponents(),
    _no_rates(),
    *_rates(),
    *_ratios(),
    Case(
        name="duration-ratio-1",
        theme=_THEME,
        asked="a force that has no time to decay, n 1",
        must="InvalidValueError: n is above 1",
        check=refused(lambda backend: power(1.0, 1.0, 1.0, 1.0)(), InvalidValueError, "duration_ratio: must be > 1"),
    ),
    Case(
        name="rise-rate-minus-701",
        theme=_THEME,
        asked="an exponential whose first force no number can hold, k1 -701",
        must="InvalidValueError: the least rate is -700",
        check=refused(
            lambda backend: exponential(-701.0, 1.0, 3.0, 1.0)(), InvalidValueError, "rise_rate: must be >= -700"
        ),
    ),
)
