"""Problems of the bench: references against other codes and other arithmetic, readings, and codes made elsewhere."""

from __future__ import annotations

from collections.abc import Callable

import mpmath as mp
import pytest
from attrs import evolve

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS, triangle
from selection import keeping
from shockwave.benchmark import chains, outside, predictors, quadratures
from shockwave.benchmark.chains import Case, Reading, method_of, read_front
from shockwave.benchmark.outside import Code, ladder
from shockwave.benchmark.timing import Clock, Limits, TooSlowError
from shockwave.benchmark.whole import Whole
from shockwave.errors import NumericalError
from shockwave.registry import load
from shockwave.simulation.nystroem import Nystroem

ONCE = Limits(run=60.0, method=0.0, repeats=0)
PATIENT = Clock(Limits(float("inf"), 0.0, 0), 0.0)
CASES = {case.name: case for case in chains.NAMED}
KNOWN = [case for case in chains.NAMED if case.known]
UNKNOWN = [case for case in chains.NAMED if not case.known]


def name_of(item: Case | Code | quadratures.Areas) -> str:
    return item.name


def worst(case: Case, reading: Reading) -> float:
    """The greater relative error of peak force and arrival time."""
    errors = case.errors(reading)
    return max(errors["peak force"] or 0.0, errors["arrival time"] or 0.0)


# ---------------------------------------------------------------- chains


@pytest.mark.parametrize("case", KNOWN, ids=name_of)
def test_tight_runs_read_the_digits_that_are_known(case: Case) -> None:
    reading = read_front(case, method_of(load("integrators", "rkn1210"), 1e-13))
    # rounding of some hundred steps
    assert worst(case, reading) < 1e-12


@pytest.mark.parametrize("case", UNKNOWN, ids=name_of)
def test_references_are_those_of_a_code_made_elsewhere(case: Case) -> None:
    (found,) = ladder(evolve(outside.SCIPY, settings=(1e-11,)), case, case.reference.time, ONCE, False)
    assert found.result is not None
    # errors of a thousand steps of 1e-11, relative and absolute
    assert worst(case, found.result) < 3e-9


@pytest.mark.parametrize("case", UNKNOWN, ids=name_of)
def test_references_state_an_error_that_two_methods_agree_to(case: Case) -> None:
    # both at a tolerance near rounding, over some hundred steps
    assert case.reference.error < 1e-11


@pytest.mark.parametrize(("name", "setting"), [("pefrl", 0.05), ("radau", 1e-4), ("rkn64", 1e-6)])
def test_a_reading_tells_peak_force_and_time_by_any_method(name: str, setting: float) -> None:
    reading = read_front(CASES["A"], method_of(load("integrators", name), setting))
    # what these settings are good for: radau's tolerance is one of a step, of which there are hundreds
    assert worst(CASES["A"], reading) < 1e-3


def test_energy_drift_is_unknown_while_the_force_acts() -> None:
    # the front passes contact 19 of B at 26, and the force ends at 100
    reading = read_front(evolve(CASES["B"], contact=19), method_of(load("integrators", "rkn86"), 1e-6))
    assert reading.drift is None


def test_energy_drift_goes_with_the_square_of_verlets_step() -> None:
    verlet = load("integrators", "verlet")
    loose, tight = (read_front(CASES["A"], verlet(size=size)).drift for size in (0.1, 0.0125))
    assert loose is not None
    assert tight is not None
    # 64 where the drift is read at the same phase of a wave, which moves it by less than that
    assert loose > 10 * tight


def test_a_march_is_stopped_by_its_clock() -> None:
    with pytest.raises(TooSlowError):
        read_front(CASES["A"], load("integrators", "verlet")(size=1e-3), Clock(Limits(0.01, 0.0, 0), 0.0))


def test_a_reference_that_is_late_is_looser_and_states_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(case: Case, integrator: Nystroem, clock: Clock | None) -> Reading:
        if clock is not None and integrator.tolerance < 1e-10:
            raise TooSlowError("stopped")
        return read_front(case, integrator, clock)

    monkeypatch.setattr(chains, "read_front", read)
    reference = evolve(CASES["short"], limits=ONCE).reference
    assert "1e-09" in reference.source
    # what two methods err by whose steps, some hundred, each err by 1e-9
    assert 1e-13 < reference.error < 1e-6
    assert reference.force == pytest.approx(CASES["short"].reference.force, rel=10 * reference.error)


def test_a_limit_that_is_late_is_looser_and_states_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(predictors, "patience", lambda _: Limits(run=0.0, method=0.0, repeats=0))
    problem, _ = predictors.rows(CASES["short"], ONCE, quick=True)
    assert "rtol 1e-06" in problem.reference
    assert 1e-9 < problem.reference_error < 1e-5


# ---------------------------------------------------------------- the whole chain


@pytest.mark.parametrize(
    "code", keeping(outside.CODES, *(code for code in outside.CODES if code.name != "scipy Radau")), ids=name_of
)
def test_each_code_is_right_or_says_why_not(code: Code) -> None:
    setting = {"tolerance": 1e-6, "step": 0.04}[code.setting]
    case = CASES["A"]
    (found,) = ladder(evolve(code, settings=(setting,)), case, case.reference.time, ONCE, False)
    if found.result is None:
        assert found.problem
        assert code.module != "scipy"
    else:
        # errors of steps of RK45 add up to hundreds of tolerances; LAMMPS is of order 2
        assert worst(case, found.result) < 1e-3


@pytest.mark.parametrize(
    ("code", "problem"),
    [
        (Code("absent", "no_such_module_anywhere", lambda _: None), "not installed"),  # type: ignore[arg-type,return-value]
        (Code("broken", "scipy", lambda _: 1 // 0), "cannot be prepared: ZeroDivisionError"),  # type: ignore[arg-type,return-value]
    ],
    ids=["absent", "broken"],
)
def test_a_code_that_cannot_be_run_is_one_entry(code: Code, problem: str) -> None:
    (found,) = ladder(code, CASES["A"], 63.7, ONCE, False)
    assert found.problem.startswith(problem)


def test_what_is_compiled_is_offered_for_power_laws_only() -> None:
    case = chains.of_scenario(_scenario("tabulated"))
    with pytest.raises(NumericalError, match="power laws only"):
        _ = Whole(case, 1.0).power


def test_a_triangle_is_a_power_law() -> None:
    # strong enough that nothing is scaled: three natural times up, six down
    whole = Whole(Case("triangle", "", triangle(9.0), CHAIN, 20), 1.0)
    assert whole.power == pytest.approx((3.0, 3.0, 1.0, 1.0, 1.0), rel=1e-12)


@pytest.mark.parametrize("name", ["exponential", "tabulated"])
def test_any_profile_is_given_to_scipy(name: str) -> None:
    case = chains.of_scenario(_scenario(name))
    (found,) = ladder(evolve(outside.SCIPY, settings=(1e-9,)), case, case.reference.time, ONCE, False)
    assert found.result is not None
    assert worst(case, found.result) < 1e-6


def test_energy_is_that_of_the_time_of_the_peak() -> None:
    # a run that goes on beyond has the same steps up to the peak, so the same energy there
    due, long = (outside.SCIPY.prepare(Whole(CASES["A"], due))(1e-3, PATIENT) for due in (63.7, 70.0))
    assert due.drift is not None
    assert due.drift == long.drift


@pytest.mark.parametrize(("granules", "given"), [(None, 99), (10**9, 99), (70, 70)])
def test_peers_get_no_more_of_the_chain_than_is_needed(granules: int | None, given: int) -> None:
    case = CASES["A"]
    # contact 59, and 40 granules ahead
    assert evolve(case, chain=evolve(case.chain, granules=granules)).granules == given


def test_a_solver_that_is_late_finds_no_peak() -> None:
    run: Callable[[float, Clock], Reading] = outside.SCIPY.prepare(Whole(CASES["A"], 30.0))
    with pytest.raises(NumericalError, match="no peak at contact 59"):
        run(1e-6, PATIENT)


# ---------------------------------------------------------------- quadratures


def test_areas_of_the_smooth_profile_are_those_of_another_arithmetic() -> None:
    with mp.workdps(30):
        rise = mp.quad(lambda s: mp.expm1(-2 * s) / mp.expm1(-2), [0, 1])
        decay = 3 * mp.quad(lambda u: (mp.exp(-3 * u) - mp.exp(-3)) / (1 - mp.exp(-3)), [0, 1])
    (smooth,) = (areas for areas in quadratures.NAMED if areas.name == "smooth")
    # both rounded to a double
    assert smooth.values == (float(rise), float(decay))


@pytest.mark.parametrize("areas", quadratures.NAMED, ids=name_of)
def test_areas_are_reached_by_a_registered_quadrature(areas: quadratures.Areas) -> None:
    method = load("quadratures", "gauss-legendre")()
    found = [method.integrate(f, p, 1e-15) for f, p in zip(areas.integrands, areas.points, strict=True)]
    # the estimate covers the error; where a kink is not told its panels go on to 1e-14
    assert max(error or 0.0 for error in areas.errors(found).values()) < 3e-14


def test_areas_of_a_profile_without_a_closed_form_are_cross_checked() -> None:
    scenario = _scenario("exponential")
    profile = scenario.shock.profile

    class Plain(sw.ShockProfile):
        duration_ratio = float(profile.duration_ratio)
        rise, decay = profile.rise, profile.decay

    plain = Plain()
    areas = quadratures.of_scenario(evolve(scenario, shock=evolve(scenario.shock, profile=plain)))
    assert "cross-checked" in areas.reference
    # to rounding
    assert areas.values == pytest.approx(profile.closed_areas(), rel=1e-14)


@pytest.mark.parametrize("wrong", [0.0, 1e-8])
def test_a_closed_form_is_cross_checked_and_its_difference_stated(wrong: float) -> None:
    scenario = _scenario("exponential")
    profile = scenario.shock.profile

    class Claimed(sw.ShockProfile):
        duration_ratio = float(profile.duration_ratio)
        rise, decay = profile.rise, profile.decay

        def closed_areas(self) -> tuple[float, float]:
            rise, decay = profile.closed_areas() or (1.0, 1.0)
            return rise, decay * (1 + wrong)

    areas = quadratures.of_scenario(evolve(scenario, shock=evolve(scenario.shock, profile=Claimed())))
    # rounding of both
    assert areas.reference_error == pytest.approx(wrong, rel=1e-6, abs=1e-14)


def _scenario(name: str) -> sw.Scenario:
    return sw.load_scenario(f"profiles/examples/{name}.yaml")


def test_named_chains_are_in_the_units_of_the_force() -> None:
    # the digits of A and B are in natural units: nothing is scaled by what a short shock makes of it
    assert all(case.scaled[1].force == pytest.approx(FORCE, rel=1e-15) for case in KNOWN)
    assert CASES["A"].problem.rise_time == pytest.approx(CASES["A"].shock.rise_time / UNITS.time, rel=1e-12)
