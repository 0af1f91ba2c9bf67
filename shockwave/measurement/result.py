"""What a simulation says."""

from __future__ import annotations

from typing import Any

from attrs import asdict, field, frozen

from shockwave.scene import Scene
from shockwave.text import indent, notes, si, table

__all__ = ["Cost", "MeasuredWave", "SimulationResult"]


@frozen(kw_only=True)
class MeasuredWave:
    """One wave as it passed a contact, in SI units.

    Attributes
    ----------
    peak_force, momentum, energy, width, granule_velocity : float
        As in `SolitaryWave`, measured from the history of the contact force.
    speed : float or None
        Of the peak along the chain [m/s]; None in a chain too short to tell.
    contact : int
        Where it was read, counted from 0: contact i lies between granules i and i + 1.
    arrival_time : float
        Of its peak there [s].
    error_estimate : float or None
        Relative, of ``peak_force`` as the limit far along the chain; None for a wave that had not settled, or that
        was found in one of the two runs only.
    foot : float
        Force left between the wave and its neighbours, over its peak: momentum, energy, width and granule velocity
        are the wave's own to about as much.
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float | None
    width: float
    granule_velocity: float
    contact: int
    arrival_time: float
    error_estimate: float | None
    foot: float


@frozen(kw_only=True)
class Cost:
    """What a result cost: both runs together; ``seconds`` vary from run to run and are left out of comparisons."""

    steps: int
    force_evaluations: int
    seconds: float = field(eq=False)


@frozen(kw_only=True)
class SimulationResult:
    """What direct simulation of eq. (1) found.

    Attributes
    ----------
    peak_force, amplification : float
        Of the primary [N]; over the shock's peak force.
    error_estimate : float
        Relative, of ``peak_force``: from a run with a looser step control and from the approach to the limit.
    waves : tuple of MeasuredWave
        Primary first; weaker than ``wave_threshold`` times the primary are not counted.
    recoil_momentum, recoil_error : float
        Of the granules that fly backwards [N s], zero or negative; and an estimate of its error [N s], with what
        granules hold that had not come apart for good.
    recoil_velocities : tuple of float
        Of the granules counted in ``ejected_granules`` [m/s], first granule first.
    ejected_granules : int
        Granules thrown back faster than a thousandth of the granules in the primary.
    wave_threshold, rtol, integrator : float, float, str
        What was asked for.
    applied_momentum : float
        Impulse of the shock [N s].
    cost : Cost
        Steps, force evaluations and seconds of both runs.
    warnings : tuple of str
        What a reader must know before using the figures.
    scene : Scene
        The shock and the chain as they were understood.
    scenario : str or None
        Name of the scenario, if it came from one.
    momentum_defect, energy_defect : float
        Relative: what the granules hold at the end against the impulse and the work of the force.
    """

    peak_force: float
    amplification: float
    error_estimate: float
    waves: tuple[MeasuredWave, ...]
    wave_threshold: float
    applied_momentum: float
    recoil_momentum: float
    recoil_error: float
    recoil_velocities: tuple[float, ...]
    ejected_granules: int
    momentum_defect: float
    energy_defect: float
    integrator: str
    rtol: float
    cost: Cost
    warnings: tuple[str, ...]
    scene: Scene
    scenario: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """What ``simulate --json`` prints: SI floats, no NaN."""
        return {
            "scenario": self.scenario,
            "peak_force": self.peak_force,
            "amplification": self.amplification,
            "error_estimate": self.error_estimate,
            "waves": [asdict(wave) for wave in self.waves],
            "wave_threshold": self.wave_threshold,
            "applied_momentum": self.applied_momentum,
            "recoil_momentum": self.recoil_momentum,
            "recoil_error": self.recoil_error,
            "recoil_velocities": list(self.recoil_velocities),
            "ejected_granules": self.ejected_granules,
            "momentum_defect": self.momentum_defect,
            "energy_defect": self.energy_defect,
            "integrator": self.integrator,
            "rtol": self.rtol,
            "cost": asdict(self.cost),
            "warnings": list(self.warnings),
            "scene": asdict(self.scene),
        }

    def __str__(self) -> str:
        waves = (
            (
                si(wave.peak_force, "N", 8),
                "not settled" if wave.error_estimate is None else f"{wave.error_estimate:.0e}",
                si(wave.momentum, "N s"),
                si(wave.energy, "J"),
                "-" if wave.speed is None else si(wave.speed, "m/s"),
                si(wave.width, "s"),
                f"{wave.foot:.0e}",
                str(wave.contact),
                si(wave.arrival_time, "s"),
            )
            for wave in self.waves
        )
        header = ("peak force", "rel. error", "momentum", "energy", "speed", "width", "foot", "contact", "arrival")
        lines = [
            f"simulation by {self.integrator}" + (f" of {self.scenario}" if self.scenario else ""),
            *self.scene.lines(),
            f"  peak force        {si(self.peak_force, 'N', 8)} within {self.error_estimate:.0e} relative, "
            f"{self.amplification:.8g} times the shock's",
            f"  applied momentum  {si(self.applied_momentum, 'N s')}, momentum defect {self.momentum_defect:.0e}, "
            f"energy defect {self.energy_defect:.0e}",
            f"  recoil            {si(self.recoil_momentum, 'N s')} within {si(self.recoil_error, 'N s', 1)}, "
            f"ejected granules: {self.ejected_granules}",
            f"  cost              {self.cost.steps} steps, {self.cost.force_evaluations} force evaluations, "
            f"{self.cost.seconds:.2g} s",
            "",
            indent(table(header, waves)),
            f"  (waves above {self.wave_threshold:g} of the primary; contacts are counted from 0; rel. error: of",
            "  the peak force; foot: force left between a wave and its neighbours over its peak, an error of the rest)",
        ]
        return "\n".join(lines + notes(self.warnings))
