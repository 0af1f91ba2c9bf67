"""The curves of Kingery and Bulmash: pressure, duration and impulse of a charge of TNT at a distance.

Each curve is Y(U) with U = offset + slope log10(Z), a polynomial in U, and 10^Y in kPa, or in ms and kPa ms
over the cube root of the charge in kg; Z = R/W^(1/3) is the scaled distance.

Kingery, C. N. and Bulmash, G. (1984). Airblast parameters from TNT spherical air burst and hemispherical
surface burst. ARBRL-TR-02555, US Army Ballistic Research Laboratory. The coefficients are those of the metric
curves; the curves of the report in feet and pounds, with other constants, give the same values within 4e-6.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Literal

from attrs import frozen

__all__ = ["FARTHEST", "NEAREST", "BlastWave", "Burst", "Loading", "blast_wave"]

Burst = Literal["surface", "free-air"]
Loading = Literal["reflected", "incident"]


@frozen
class _Piece:
    """A curve up to the scaled distance ``end`` [m/kg^(1/3)]."""

    end: float
    offset: float
    slope: float
    coefficients: tuple[float, ...]

    def at(self, distance: float) -> float:
        variable = self.offset + self.slope * math.log10(distance)
        exponent = 0.0
        for coefficient in reversed(self.coefficients):
            exponent = exponent * variable + coefficient
        return float(10.0**exponent)


@frozen
class BlastWave:
    """Peak overpressure [Pa], duration [s] and impulse [Pa s] of the positive phase."""

    pressure: float
    duration: float
    impulse: float


#: Greatest scaled distance of all curves [m/kg^(1/3)].
FARTHEST = 40.0
#: Least scaled distance of the curves of the duration [m/kg^(1/3)].
NEAREST: Mapping[str, float] = MappingProxyType({"surface": 0.178, "free-air": 0.147})


def blast_wave(charge_mass: float, standoff: float, burst: Burst, loading: Loading) -> BlastWave:
    """The blast wave of ``charge_mass`` [kg] TNT at ``standoff`` [m], between `NEAREST` and `FARTHEST`.

    The duration is that of the incident wave, for a reflected wave as well, as is usual in the field.
    """
    root = math.cbrt(charge_mass)
    distance = standoff / root
    pressure = _value(_CURVES[f"{burst} {loading} pressure"], distance)
    impulse = _value(_CURVES[f"{burst} {loading} impulse"], distance)
    duration = _value(_CURVES[f"{burst} duration"], distance)
    return BlastWave(1e3 * pressure, 1e-3 * root * duration, root * impulse)  # kPa ms is Pa s


def _value(pieces: Sequence[_Piece], distance: float) -> float:
    piece = next((piece for piece in pieces if distance <= piece.end), pieces[-1])
    return piece.at(distance)


_CURVES: Mapping[str, tuple[_Piece, ...]] = {
    "surface incident pressure": (
        _Piece(
            40.0,
            -0.214362789151,
            1.35034249993,
            (
                2.78076916577,
                -1.6958988741,
                -0.154159376846,
                0.514060730593,
                0.0988534365274,
                -0.293912623038,
                -0.0268112345019,
                0.109097496421,
                0.00162846756311,
                -0.0214631030242,
                0.0001456723382,
                0.00167847752266,
            ),
        ),
    ),
    "surface incident impulse": (
        _Piece(
            0.955,
            2.06761908721,
            3.0760329666,
            (2.52455620925, -0.502992763686, 0.171335645235, 0.0450176963051, -0.0118964626402),
        ),
        _Piece(
            40.0,
            -1.94708846747,
            2.40697745406,
            (
                1.67281645863,
                -0.384519026965,
                -0.0260816706301,
                0.00595798753822,
                0.014544526107,
                -0.00663289334734,
                -0.00284189327204,
                0.0013644816227,
            ),
        ),
    ),
    "surface reflected pressure": (
        _Piece(
            40.0,
            -0.240657322658,
            1.36637719229,
            (
                3.40283217581,
                -2.21030870597,
                -0.218536586295,
                0.895319589372,
                0.24989009775,
                -0.569249436807,
                -0.11791682383,
                0.224131161411,
                0.0245620259375,
                -0.0455116002694,
                -0.00190930738887,
                0.00361471193389,
            ),
        ),
    ),
    "surface reflected impulse": (
        _Piece(
            40.0,
            -0.246208804814,
            1.33422049854,
            (2.70588058103, -0.949516092853, 0.112136118689, -0.0250659183287),
        ),
    ),
    "surface duration": (
        _Piece(
            1.01,
            1.92946154068,
            5.25099193925,
            (
                -0.614227603559,
                0.130143717675,
                0.134872511954,
                0.0391574276906,
                -0.00475933664702,
                -0.00428144598008,
            ),
        ),
        _Piece(
            2.78,
            -2.12492525216,
            9.2996288611,
            (
                0.315409245784,
                -0.0297944268976,
                0.030632954288,
                0.0183405574086,
                -0.0173964666211,
                -0.00106321963633,
                0.00562060030977,
                0.0001618217499,
                -0.0006860188944,
            ),
        ),
        _Piece(
            40.0,
            -3.53626218091,
            3.46349745571,
            (
                0.686906642409,
                0.0933035304009,
                -0.0005849420883,
                -0.00226884995013,
                -0.00295908591505,
                0.00148029868929,
            ),
        ),
    ),
    "free-air incident pressure": (
        _Piece(
            40.0,
            -0.214362789151,
            1.35034249993,
            (
                2.611368669,
                -1.69012801396,
                0.00804973591951,
                0.336743114941,
                -0.00516226351334,
                -0.0809228619888,
                -0.00478507266747,
                0.00793030472242,
                0.0007684469735,
            ),
        ),
    ),
    "free-air incident impulse": (
        _Piece(
            0.792,
            2.34723921354,
            3.24299066475,
            (2.38830516757, -0.443749377691, 0.168825414684, 0.0348138030308, -0.010435192824),
        ),
        _Piece(
            40.0,
            -1.75305660315,
            2.30629231803,
            (
                1.55197227115,
                -0.40463292088,
                -0.0142721946082,
                0.00912366316617,
                -0.0006750681404,
                -0.00800863718901,
                0.00314819515931,
                0.00152044783382,
                -0.0007470265899,
            ),
        ),
    ),
    "free-air reflected pressure": (
        _Piece(
            40.0,
            -0.214362789151,
            1.35034249993,
            (
                3.22958031387,
                -2.21400538997,
                0.035119031446,
                0.657599992109,
                0.0141818951887,
                -0.243076636231,
                -0.0158699803158,
                0.0492741184234,
                0.00227639644004,
                -0.00397126276058,
            ),
        ),
    ),
    "free-air reflected impulse": (
        _Piece(
            40.0,
            -0.204004553231,
            1.37882996018,
            (2.55875660396, -0.903118886091, 0.101771877942, -0.0242139751146),
        ),
    ),
    "free-air duration": (
        _Piece(
            0.888,
            2.26367268496,
            5.11588554305,
            (
                -0.686608550419,
                0.164953518069,
                0.127788499497,
                0.00291430135946,
                0.00187957449227,
                0.0173413962543,
                0.00269739758043,
                -0.00361976502798,
                -0.00100926577934,
            ),
        ),
        _Piece(
            2.28,
            -1.33361206714,
            9.2996288611,
            (
                0.23031841078,
                -0.0297944268969,
                0.0306329542941,
                0.018340557407,
                -0.0173964666286,
                -0.00106321963576,
                0.0056206003128,
                0.0001618217499,
                -0.0006860188944,
            ),
        ),
        _Piece(
            40.0,
            -3.13005805346,
            3.1524725364,
            (
                0.621036276475,
                0.0967031995552,
                -0.00801302059667,
                0.00482705779732,
                0.00187587272287,
                -0.00246738509321,
                -0.000841116668,
                0.0006193291052,
            ),
        ),
    ),
}
