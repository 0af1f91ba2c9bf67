"""The outcome of a prediction: simulated values, computed when first read, and the decision of section 4."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from attrs import evolve, field, frozen

from shockwave.base.errors import Fault, InvalidValueError, NumericalError, ShockwaveError, detach
from shockwave.base.result import VERSION, cached_property
from shockwave.base.text import render
from shockwave.prediction.scaled_shock import Inequality, Regime, Relation
from shockwave.prediction.section4 import relation_of
from shockwave.prediction.section4_outcome import Section4Outcome
from shockwave.profiles.area_conditions import Condition
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import WAVE, LeavingForce, name_force
from shockwave.scene.plausibility import unusual_warnings
from shockwave.scene.scene import Scene
from shockwave.scene.scene_result import SceneResult
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.yielding import BEYOND, Yielding, find_yielding, warn_beyond

if TYPE_CHECKING:  # a result that is only printed does not need them
    from shockwave.simulation.result_parts import ContactPeak, Structure, Transmitted

_FAILS = (
    "The shock fails conditions (3), for which section 4 was derived: its error is not known here. Simulate to obtain"
    " an accurate peak force."
)

# Attributes that the document contains under their names.
_KEYS = (
    *("scenario", "model", "method", "peak_force", "low", "high", "amplification", "relation", "reason"),
    *("greatest_force", "transmitted", "structure", "verdict", "yield", "regime", "conditions", "ejection", "trace"),
    *("waves", "section4", "section4_reason", "applied_momentum"),
)


class Relations(Protocol):
    """Settings of a prediction, with the relations of section 4; a `Predictor`."""

    @property
    def model(self) -> str:
        """``best`` or ``section-4``."""

    @property
    def equal_tolerance(self) -> float:
        """Relative difference called equal."""

    def relations(self, scene: Scene, simulated_force: Any = ...) -> Section4Outcome:
        """Prediction of section 4."""


@frozen(kw_only=True, slots=False, repr=False)
class Outcome(SceneResult):
    """The prediction for one scene.

    The simulation runs when one of its values is first read, and its result is kept. Only a faulty plugin raises an
    error then: where there is no answer the values are None, and ``reason`` states why. Two outcomes are equal if
    scene, settings and options are equal.

    Attributes
    ----------
    scene : Scene
        Shock or impact, and chain.
    predictor : Predictor
        Settings of the prediction.
    options : SimulateOptions
        Options of the simulation.
    simulation : callable or None
        Function that returns the result of the simulation or its error; None if the model is ``section-4``.
    """

    scene: Scene
    predictor: Relations
    options: SimulateOptions
    simulation: Callable[[], Any] | None = field(eq=False, repr=False)

    # ---------------------------------------------------------------- the simulation

    @property
    def model(self) -> str:
        """``best`` or ``section-4``."""
        return self.predictor.model

    @cached_property
    def simulated(self) -> Any:
        """Result of the simulation, as `shockwave.simulate` returns it; None where there is none."""
        result = None if self.simulation is None else self.simulation()
        return None if isinstance(result, ShockwaveError) else result

    @property
    def reason(self) -> str | None:
        """Reason why the simulation failed, and a remedy."""
        result = None if self.simulation is None else self.simulation()
        return str(result) if isinstance(result, ShockwaveError) else None

    @property
    def method(self) -> str:
        """Method of the first numbers: ``simulation`` or ``section-4``."""
        return "section-4" if self.simulation is None else "simulation"

    def _read(self, name: str) -> Any:
        """Attribute of the simulation; None where it has none."""
        try:
            return getattr(self.simulated, name, None)
        except NumericalError:
            return None

    # ---------------------------------------------------------------- the leading wave

    @property
    def peak_force(self) -> float | Any:
        """Peak force of the leading wave [N]; None in chains without a steady leading wave."""
        return self._paper.peak_force if self.simulation is None else self._read("peak_force")

    @property
    def low(self) -> float | Any:
        """Peak force less its error estimate [N]; None where the error is not known."""
        return self._range_end(-1)

    @property
    def high(self) -> float | Any:
        """Peak force plus its error estimate [N]; None where the error is not known."""
        return self._range_end(1)

    def _range_end(self, sign: int) -> float | Any:
        peak, error = self._read("peak_force"), self._read("error_estimate")
        return None if peak is None or not error < 1 else float(peak * (1 + sign * error))

    @property
    def amplification(self) -> float | Any:
        """Peak force of the leading wave over that of the shock."""
        return self._paper.amplification if self.simulation is None else self._read("amplification")

    @property
    def relation(self) -> Relation | None:
        """``less``, ``equal`` or ``greater``: the leading wave relative to the peak force of the shock."""
        if self.simulation is None:
            return self._paper.relation
        ratio = self.amplification
        return None if ratio is None else relation_of(ratio, self.predictor.equal_tolerance)

    @property
    def waves(self) -> tuple[Any, ...]:
        """The leading wave alone, where there is one; all waves of section 4 if the model is ``section-4``."""
        if self.simulation is None:
            return self._paper.waves
        return () if self.peak_force is None else (self._read("primary"),)

    # ---------------------------------------------------------------- other forces

    @property
    def greatest_force(self) -> ContactPeak | Any:
        """Greatest contact force, as of a simulation."""
        return self._read("greatest_force")

    @property
    def contacts(self) -> tuple[ContactPeak, ...]:
        """Greatest forces at the contacts, as of a simulation."""
        return self._read("contacts") or ()

    @property
    def transmitted(self) -> Transmitted | Any:
        """Force on the wall; None without a wall."""
        return self._read("transmitted")

    @property
    def structure(self) -> Structure | Any:
        """Motion of a movable end; None without one."""
        return self._read("structure")

    @property
    def leaving(self) -> LeavingForce:
        """The transmitted force, on the wall, at the last contact, or of the wave in an endless chain."""
        name = WAVE if self.chain.count is None else name_force(self.chain.end)
        unknown = LeavingForce(name=name, remedy="simulate")
        if self.simulation is not None:
            unknown = evolve(unknown, remedy="simulate with a longer timeout or a larger rtol")
        return self._read("leaving") or unknown

    @property
    def yielding(self) -> Yielding | None:
        """First yield of the contacts; None without a yield strength."""
        if self.simulation is None:
            return find_yielding(self.chain, max(wave.peak_force for wave in self.waves))
        first_yield: Yielding | None = self._read("yielding")
        return first_yield

    @property
    def applied_momentum(self) -> float | Any:
        """Impulse of the shock or momentum of the striker [N s]."""
        if isinstance(self.excitation, Shock):
            shock = self.excitation
            return float(shock.peak_force * shock.rise_time * shock.profile.total_area)
        impact = self.scene.impact
        if impact is None:
            return self._read("applied_momentum")
        material = impact.material or self.chain.material
        striker = Chain(material=material, radius=impact.radius or self.chain.radius)
        return striker.granule_mass * impact.speed(self.chain.gravity)

    # ---------------------------------------------------------------- section 4

    @cached_property
    def _relations(self) -> Section4Outcome | ShockwaveError:
        try:
            # a method of this object would be a reference to itself
            force = partial(_peak_force, self.simulation)
            return self.predictor.relations(self.scene, force)
        except (InvalidValueError, NumericalError) as error:
            return detach(error)

    @property
    def _paper(self) -> Section4Outcome:
        """Section 4, where the first numbers are its own."""
        if isinstance(self._relations, ShockwaveError):
            raise self._relations
        return self._relations

    @property
    def section4(self) -> Section4Outcome | Any:
        """Prediction of section 4 of the paper; None where it does not apply, see ``section4_reason``."""
        if self.simulation is None:
            return self._paper
        return None if isinstance(self._relations, ShockwaveError) else self._relations

    @property
    def section4_faults(self) -> tuple[Fault, ...]:
        """Features of the scene that section 4 does not cover, with their places in the file, or another reason."""
        error = self._relations
        if not isinstance(error, ShockwaveError):
            return ()
        return tuple(map(self.scene.place_fault, error.faults))

    @property
    def section4_reason(self) -> str | None:
        """Reason why section 4 does not apply, with the places in the file."""
        return "\n".join(map(str, self.section4_faults)) or None

    @property
    def regime(self) -> Regime | None:
        """``ejection``, ``single`` or ``train``, by section 4."""
        return None if self.section4 is None else self.section4.regime

    @property
    def conditions(self) -> tuple[Condition, ...] | Any:
        """Conditions (3)."""
        return None if self.section4 is None else self.section4.conditions

    @property
    def ejection(self) -> dict[str, float] | None:
        """Virtual rise time [s] and added momentum [N s] of section 4, in the regime ``ejection``."""
        return None if self.section4 is None else self.section4.ejection

    @property
    def trace(self) -> tuple[Inequality, ...] | None:
        """Inequalities of section 4 that decided; both sides in seconds."""
        return None if self.section4 is None else self.section4.trace

    # ---------------------------------------------------------------- text and documents

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the first numbers; those on unusual values and on first yield come first."""
        if (result := self.simulated) is None:
            return self.first_warnings
        units = unusual_warnings(self.excitation, self.chain)
        first = (*units, *warn_beyond(self.yielding, self.chain), *result.value_with_yield)
        return tuple(dict.fromkeys((*first, *self.first_warnings)))

    @property
    def first_warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the first numbers."""
        result = self.simulated
        beyond = warn_beyond(self.yielding, self.chain)
        if result is not None:
            # train warnings do not affect the first numbers; first yield is stated once, for the greatest force
            others = (each for each in result.first_warnings if not each.startswith(BEYOND))
            return (*others, *beyond)
        usual = unusual_warnings(self.excitation, self.chain)
        if self.simulation is not None:
            return usual
        fails = () if self._paper.holds else (_FAILS,)
        return (*usual, *fails, *self._paper.warnings, *beyond)

    _brief = ("scenario", "model", "limit.force")
    _tables = (("waves", "wave"), ("conditions", "condition"), ("contacts", "contact"))

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``predict --json``: SI floats, no NaN."""
        document = VERSION | self._document(*_KEYS) | {"scene": self.scene.summary().numbers}
        if (wall := self.transmitted) is not None:
            document["transmitted"] |= {"low": wall.low, "high": wall.high}
            document["transmitted"] |= {} if wall.peak_force else {"high": None, "error_estimate": None}
        return document | self._document("warnings", "notes")

    def __str__(self) -> str:
        return render(self, "shockwave.prediction.outcome_text:outcome_text")


def _peak_force(simulation: Callable[[], Any] | None) -> float | None:
    """Simulated peak force of the leading wave [N]; None where there is none."""
    return None if simulation is None else getattr(simulation(), "peak_force", None)
