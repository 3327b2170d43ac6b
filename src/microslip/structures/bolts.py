"""Bolts of a lap joint: positions, dimensions, and the tension by tightening."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, positive, positives
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import parameter, parameters_of
from microslip.contact.materials import Material
from microslip.friction.pressure import BOLTS
from microslip.structures.bolt_tightening import (
    TIGHTENING_FACTOR,
    Thread,
    proof_stress,
    size_named,
    tension_band,
)


def metres(symbol: str, meaning: str, example: float) -> dict[str, Any]:
    """Return metadata of a dataclass field for a length above zero [m], see :func:`parameter`."""
    return parameter(symbol, "m", meaning, above=0.0, example=example)


def _friction(symbol: str, meaning: str) -> dict[str, Any]:
    return parameter(symbol, meaning=meaning, above=0.0, example=0.12)


@dataclass(frozen=True, eq=False)
class Bolts(Locked):
    """Equal bolts through a lap, with their holes and washers.

    Parameters
    ----------
    positions : array_like
        Positions along the lap from its middle [m], or pairs of positions along and across it.
    shank : float
        Diameter of the shank [m].
    hole : float
        Diameter of the holes [m], above that of the shank.
    washer : float
        Outer diameter of the washers [m], above the hole; the width of the heads without washers.
    tension : float or array_like, optional
        Tension of each bolt after tightening [N], one number for all or one for each.
    torque : float or array_like, optional
        Tightening torque [N m] in place of the tension.
    thread : float, optional
        Nominal diameter d of the thread [m]; a torque needs it.
    nut_factor : float, optional
        K of torque = K d tension [-] (ISO 16047), such as 0.2 for dry steel.
    pitch : float, optional
        Pitch P of the thread [m]; with both friction coefficients it replaces the nut factor.
    thread_friction, bearing_friction : float, optional
        Coefficients of friction in the thread and under the turned head or nut [-].
    head : float, optional
        Width of head and nut [m], above the hole; by default 1.6 shank diameters, but no wider than
        the washer.
    washer_thickness : float, optional
        Thickness of a washer [m]; by default a fifth of the shank diameter.
    mass : float, optional
        Total mass of head, nut and both washers of a bolt [kg]; by default that of the washers and
        of hexagons 1.5 shank diameters high in total, with the density of the bolts.
    material : Material, optional
        Material of the bolts; by default that of the plates.
    density : float, optional
        Mass density of the bolts [kg/m^3]; by default that of the plates.
    size : str, optional
        Metric size such as "M8", which sets shank, hole, head, washer, washer_thickness, thread
        and pitch: heads of ISO 4014, nuts of ISO 4032, washers of ISO 7089, medium holes of
        ISO 273, coarse threads.
    grade : str, optional
        Property class such as "8.8" (ISO 898-1); tensions that yield the bolt are rejected.
    tightening_factor : float, optional
        VDI 2230's alpha_A [-], the largest preload over the smallest at one torque: 1.2 to 1.4 with
        a torque set by tests on the joint, 1.4 to 1.6 by measured friction, 1.6 to 2 by estimated
        friction, 2.5 to 4 with an impact wrench.

    Notes
    -----
    With friction coefficients, torque M and tension F are related by VDI 2230 for threads of 60
    degrees, M = F [0.16 P + 0.58 d2 mu_G + (D_Km / 2) mu_K], d2 = d - 0.6495 P. D_Km is the mean of
    the diameters of the hole and of the bearing face of the head (d_w of ISO 4014 for a size, else
    0.9 of the width of the head). A washer is bonded to its plate within the diameter
    head + 1.6 washer_thickness (VDI 2230-1); outside it adds mass only. Tensions scatter by 20 to
    30 % at the same torque; on the loss of tension see Croccolo et al. (2023),
    DOI 10.3390/machines11020212.
    """

    positions: Any
    # Always set after creation: given, or by the size.
    shank: float = field(
        default=None,  # type: ignore[assignment]
        metadata=metres("d_s", "diameter of the shanks", 0.008),
    )
    hole: float = field(
        default=None,  # type: ignore[assignment]
        metadata=metres("d_h", "diameter of the holes", 0.009),
    )
    washer: float = field(
        default=None,  # type: ignore[assignment]
        metadata=metres("d_2", "outer diameter of the washers", 0.016),
    )
    tension: Any = field(
        default=None,
        metadata=parameter("F", "N", "tension of each bolt", above=0.0, example="12 kN"),
    )
    torque: Any = field(
        default=None,
        metadata=parameter(
            "M", "N*m", "tightening torque instead of the tension", above=0.0, example="20 N m"
        ),
    )
    thread: float | None = field(
        default=None,
        metadata=metres("d", "nominal diameter of the thread, for a torque", 0.008),
    )
    nut_factor: float | None = field(
        default=None,
        metadata=parameter(
            "K", meaning="K of torque = K d tension, 0.2 for dry steel", above=0.0, example=0.2
        ),
    )
    pitch: float | None = field(
        default=None,
        metadata=metres("P", "pitch of the thread, with two frictions", 0.00125),
    )
    thread_friction: float | None = field(
        default=None, metadata=_friction("mu_G", "friction in the thread")
    )
    bearing_friction: float | None = field(
        default=None, metadata=_friction("mu_K", "friction under the turned head or nut")
    )
    head: float = field(
        default=None,  # type: ignore[assignment]
        metadata=metres("s", "width of head and nut, 1.6 shank diameters unless given", 0.013),
    )
    washer_thickness: float = field(
        default=None,  # type: ignore[assignment]
        metadata=metres("h", "thickness of a washer, a fifth of the shank unless given", 0.0016),
    )
    mass: float | None = field(
        default=None,
        metadata=parameter(
            "m", "kg", "mass of head, nut and both washers of a bolt", above=0.0, example=0.015
        ),
    )
    material: Material | None = None
    density: float | None = field(
        default=None,
        metadata=parameter("rho", "kg/m^3", "mass density of the bolts", above=0.0, example=7850.0),
    )
    size: str | None = None
    grade: str | None = None
    tightening_factor: float | None = field(
        default=None,
        metadata=parameter(
            "alpha_A", meaning="largest over smallest preload at one torque", least=1.0,
            example=1.6,
        ),
    )  # fmt: skip

    def __post_init__(self) -> None:
        assign(self, positions=lock(_places(self.positions)))
        if self.size is not None:
            given = {name: getattr(self, name) for name in SIZED}
            assign(self, **by_size(self.size, self.thread_friction, **given))
        for name in ("shank", "hole", "washer"):
            if getattr(self, name) is None:
                raise InputError(
                    f"`{name}` missing: bolts need shank, hole and washer, or a size such as "
                    'size="M8"'
                )
        for declared in parameters_of(Bolts):
            if declared.name not in ("tension", "torque"):  # which may be one a bolt
                assign(self, **{declared.name: declared.checked(getattr(self, declared.name))})
        if not self.shank < self.hole < self.washer:
            raise InputError(
                "a shank must fit into its hole and the washer must cover the hole, got "
                f"shank={exact(self.shank)}, hole={exact(self.hole)}, "
                f"washer={exact(self.washer)} [m]"
            )
        if self.head is None:
            assign(self, head=min(1.6 * self.shank, self.washer))
        if self.washer_thickness is None:
            assign(self, washer_thickness=0.2 * self.shank)
        if not self.hole < self.head <= self.washer:
            raise InputError(
                "`head` must be a width above the hole and at most that of the washer, got "
                f"head={exact(self.head)}, hole={exact(self.hole)}, "
                f"washer={exact(self.washer)} [m]"
            )
        if self.material is not None and not isinstance(self.material, Material):
            raise InputError(f"material must be a Material, got {self.material!r:.60}")
        if self.torque is not None:
            assign(self, torque=lock(each_bolt("torque", self.torque, len(self), "N m")))
        assign(self, tension=lock(tensions(self, len(self))))

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def tension_range(self) -> tuple[Floats, Floats]:
        """Smallest and largest tension [N] by the tightening factor, 1.6 for a torque by default.

        Their mean is ``tension``. Both are equal to it if tensions are given without a factor.
        """
        factor = self.tightening_factor
        if factor is None:
            factor = 1.0 if self.torque is None else TIGHTENING_FACTOR
        low, high = tension_band(factor)
        return low * self.tension, high * self.tension

    @property
    def utilisation(self) -> Floats:
        """Equivalent stress in tightening over the proof stress of the grade [-], one per bolt.

        VDI 2230 permits 0.9. The torsion is that of the thread friction, 0.12 by default.
        """
        if self.size is None or self.grade is None:
            raise InputError('the stress of bolts needs size="M8" and grade="8.8"')
        return np.asarray(self.tension / yield_tension(self))

    @property
    def pressed(self) -> float:
        """Diameter within which a washer is bonded to its plate [m], see the notes of the class."""
        return min(self.head + 1.6 * self.washer_thickness, self.washer)

    def fixing_mass(self, density: float) -> float:
        """Return the mass of head, nut and washers [kg]: ``mass``, else by the density [kg/m^3]."""
        density = positive("density", density, "kg/m^3", 7850.0)
        if self.mass is not None:
            return self.mass
        heights = 1.5 * self.shank if self.size is None else size_named(self.size).heights
        hexagons = 0.5 * math.sqrt(3.0) * self.head**2 * heights
        rings = 0.5 * math.pi * (self.washer**2 - self.shank**2) * self.washer_thickness
        return density * (hexagons - 0.125 * math.pi * self.shank**2 * heights + rings)


def yield_tension(bolts: Any) -> float:
    """Return the tension [N] at which a bolt yields in tightening, with torsion by its thread."""
    if bolts.size is None:
        raise InputError('`grade` needs the size of the bolts, such as size="M8"')
    bolt = size_named(bolts.size)
    friction = 0.12 if bolts.thread_friction is None else float(bolts.thread_friction)
    thread = Thread(bolt.diameter, bolt.pitch)
    return proof_stress(bolts.grade, bolt.diameter) / thread.reduced_stress(1.0, friction)


SIZED = ("shank", "hole", "head", "washer", "washer_thickness", "thread", "pitch")
"""Dimensions that follow from the size of a bolt."""


def by_size(size: object, thread_friction: float | None, **given: Any) -> dict[str, Any]:
    """Return the dimensions of a bolt [m] by name: given values, else those of a metric size.

    A size sets the pitch only if ``thread_friction`` is given: else a torque needs the nut factor.
    """
    bolt = size_named(size)
    known = {
        "shank": bolt.diameter, "hole": bolt.hole, "head": bolt.flats, "washer": bolt.washer,
        "washer_thickness": bolt.washer_thickness, "thread": bolt.diameter,
    }  # fmt: skip
    if thread_friction is not None:  # else a torque goes by its nut factor
        known["pitch"] = bolt.pitch
    if given.get("washer") is not None:
        known["head"] = min(bolt.flats, float(given["washer"]))
    return {name: known.get(name) if given.get(name) is None else given[name] for name in SIZED}


def tensions(bolts: Any, count: int) -> Floats:
    """Return the tension of each of ``count`` bolts [N], as given or from the torque.

    ``bolts`` has those attributes of :class:`Bolts` that give tightening, dimensions and grade.
    Raise an InputError if both or neither of tension and torque are given, if a torque lacks a nut
    factor or friction coefficients, or if a bolt of the size and grade would yield.
    """
    if (bolts.tension is None) == (bolts.torque is None):
        raise InputError(
            "bolts need their tension or their tightening torque, "
            f"{'not both' if bolts.torque is not None else 'for example tension=12e3'}"
        )
    if bolts.torque is None:
        result = each_bolt("tension", bolts.tension, count, "N")
    else:
        lever = _lever(bolts)
        result = each_bolt("torque", bolts.torque, count, "N m") / lever
    if bolts.grade is not None:
        most = yield_tension(bolts)
        if result.max() > most:
            given = "" if bolts.torque is None else f", by a torque of {most * lever:.4g} N m"
            raise InputError(
                f"`tension` must be at most {most:.4g} N{given}, at which a {bolts.size} of grade "
                f"{bolts.grade} yields as it is tightened, got {result.max():.4g} N"
            )
    return result


def _lever(bolts: Any) -> float:
    """Return torque over tension [m], by the nut factor or by the friction coefficients."""
    if bolts.thread is None:
        raise InputError(
            "a torque needs the nominal diameter of the thread, for example thread=0.008"
        )
    frictions = (bolts.pitch, bolts.thread_friction, bolts.bearing_friction)
    if bolts.nut_factor is not None and frictions == (None, None, None):
        return float(bolts.nut_factor * bolts.thread)
    if bolts.nut_factor is not None or None in frictions:
        raise InputError(
            "a torque needs one rule: nut_factor (such as 0.2), or pitch, thread_friction and "
            "bearing_friction together"
        )
    pitch_diameter = Thread(bolts.thread, bolts.pitch).pitch_diameter
    if pitch_diameter <= 0.0:
        raise InputError(
            f"pitch must be small compared with the thread {exact(bolts.thread)} m, got "
            f"{exact(bolts.pitch)}"
        )
    if bolts.hole is None or bolts.head is None:
        raise InputError("friction under the head needs the diameters of hole and head, or a size")
    # The face that turns on the plate reaches from the hole to the bearing diameter of the head.
    face = 0.9 * bolts.head if bolts.size is None else min(BOLTS[bolts.size].head, bolts.head)
    bearing = 0.5 * (bolts.hole + max(face, bolts.hole))
    return float(
        bolts.pitch / (2.0 * math.pi)
        + pitch_diameter * bolts.thread_friction / (2.0 * math.cos(math.pi / 6.0))
        + 0.5 * bearing * bolts.bearing_friction
    )


def _places(positions: ArrayLike) -> Floats:
    array = floats("positions", positions, "m")
    if array.ndim <= 1:
        array = np.stack([np.atleast_1d(array), np.zeros(array.size)], axis=1)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(
            "positions must be coordinates along the lap [m], or pairs along and across it, got "
            f"shape {array.shape}"
        )
    if len(np.unique(array, axis=0)) != len(array):
        raise InputError("positions must differ from bolt to bolt, got one twice")
    return array.copy()


def each_bolt(name: str, value: ArrayLike, count: int, unit: str) -> Floats:
    """Validate one positive number, or one for each bolt, and return one for each bolt."""
    array = floats(name, value)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise InputError(
            f"{name} must be one number [{unit}], or one for each of the {count} bolts, got shape "
            f"{array.shape}"
        )
    return positives(name, array, unit).copy()
