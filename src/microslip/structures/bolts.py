"""Bolts of a lap joint: where they sit, what they are, and the tension that tightening gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, positive
from microslip._core.frozen import Locked, assign, lock
from microslip.errors import InputError
from microslip.materials import Material


@dataclass(frozen=True, eq=False)
class Bolts(Locked):
    """Equal bolts through a lap, with their holes and their washers.

    Parameters
    ----------
    positions : array_like
        Places along the lap [m], from its middle; or pairs of places along and across it.
    shank : float
        Diameter of the shank [m].
    hole : float
        Diameter of the holes [m], above that of the shank.
    washer : float
        Outer diameter of what presses on the plates [m]: a washer, or the head; above the hole.
    tension : float or array_like, optional
        Tension of each bolt after tightening [N], one number for all or one for each.
    torque : float or array_like, optional
        Tightening torque [N m] in place of the tension.
    thread : float, optional
        Nominal diameter d of the thread [m]; a torque needs it.
    nut_factor : float, optional
        K of torque = K d tension [-] (ISO 16047), such as 0.2 for dry steel.
    pitch : float, optional
        Pitch P of the thread [m]; with the two frictions it takes the place of the nut factor.
    thread_friction, bearing_friction : float, optional
        Coefficients of friction in the thread and under the turned head or nut [-].
    head : float, optional
        Height of a head, and of a nut, with its washer [m]: each is a disc as wide as the washer;
        0.8 of the shank's diameter unless given.
    material : Material, optional
        Of the bolts; that of the plates unless given.
    density : float, optional
        Of the bolts [kg/m^3]; that of the plates unless given.

    Notes
    -----
    With frictions given, the torque follows VDI 2230 for threads of 60 degrees,
    M = F [0.16 P + 0.58 d2 mu_G + (D_Km / 2) mu_K], d2 = d - 0.6495 P, with the mean diameter D_Km
    of the ring between hole and washer. Tensions scatter by 20 to 30 % at the same torque: on how
    threaded connections lose theirs see Croccolo et al. (2023), DOI 10.3390/machines11020212.
    """

    positions: Any
    shank: float
    hole: float
    washer: float
    tension: Any = None
    torque: Any = None
    thread: float | None = None
    nut_factor: float | None = None
    pitch: float | None = None
    thread_friction: float | None = None
    bearing_friction: float | None = None
    head: float | None = None
    material: Material | None = None
    density: float | None = None

    def __post_init__(self) -> None:
        assign(self, positions=lock(_places(self.positions)))
        for name, example in (("shank", 0.008), ("hole", 0.009), ("washer", 0.018)):
            assign(self, **{name: positive(name, getattr(self, name), "m", example)})
        if not self.shank < self.hole < self.washer:
            raise InputError(
                "a shank must fit into its hole and the washer must cover the hole, got "
                f"shank={exact(self.shank)}, hole={exact(self.hole)}, "
                f"washer={exact(self.washer)} [m]"
            )
        for name, unit, example in (
            ("thread", "m", 0.008),
            ("nut_factor", "", 0.2),
            ("pitch", "m", 0.00125),
            ("thread_friction", "", 0.12),
            ("bearing_friction", "", 0.12),
            ("density", "kg/m^3", 7850.0),
        ):
            if getattr(self, name) is not None:
                assign(self, **{name: positive(name, getattr(self, name), unit, example)})
        head = 0.8 * self.shank if self.head is None else self.head
        assign(self, head=positive("head", head, "m", 0.006))
        if self.material is not None and not isinstance(self.material, Material):
            raise InputError(f"material must be a Material, got {self.material!r:.60}")
        if self.torque is not None:
            assign(self, torque=lock(each_bolt("torque", self.torque, len(self), "N m")))
        tightening = {name: getattr(self, name) for name in TIGHTENING}
        bearing = 0.5 * (self.hole + self.washer)
        assign(self, tension=lock(tensions(len(self), **tightening, bearing=bearing)))

    def __len__(self) -> int:
        return len(self.positions)


TIGHTENING = (
    "tension", "torque", "thread", "nut_factor", "pitch", "thread_friction", "bearing_friction",
)  # fmt: skip
"""What says how tight bolts are."""


def tensions(
    count: int, *, tension: Any, torque: Any, bearing: float | None, **rule: float | None
) -> Floats:
    """Tension of each bolt [N], given or by its torque."""
    if (tension is None) == (torque is None):
        raise InputError(
            "bolts need their tension or their tightening torque, "
            f"{'not both' if torque is not None else 'for example tension=12e3'}"
        )
    if torque is None:
        return each_bolt("tension", tension, count, "N")
    return each_bolt("torque", torque, count, "N m") / _lever(bearing, **rule)


def _lever(
    bearing: float | None,
    thread: float | None,
    nut_factor: float | None,
    pitch: float | None,
    thread_friction: float | None,
    bearing_friction: float | None,
) -> float:
    """Torque over tension [m]."""
    if thread is None:
        raise InputError(
            "a torque needs the nominal diameter of the thread, for example thread=0.008"
        )
    frictions = (pitch, thread_friction, bearing_friction)
    if nut_factor is not None and frictions == (None, None, None):
        return nut_factor * thread
    if (
        nut_factor is not None
        or pitch is None
        or thread_friction is None
        or bearing_friction is None
    ):
        raise InputError(
            "a torque needs one rule: nut_factor (such as 0.2), or pitch, thread_friction and "
            "bearing_friction together"
        )
    pitch_diameter = thread - 0.375 * math.sqrt(3.0) * pitch
    if pitch_diameter <= 0.0:
        raise InputError(
            f"pitch must be small beside the thread {exact(thread)} m, got {exact(pitch)}"
        )
    if bearing is None:
        raise InputError("friction under the head needs the diameters of hole and washer")
    return (
        pitch / (2.0 * math.pi)
        + pitch_diameter * thread_friction / (2.0 * math.cos(math.pi / 6.0))
        + 0.5 * bearing * bearing_friction
    )


def _places(positions: ArrayLike) -> Floats:
    """Places along and across the lap, one row a bolt."""
    array = floats("positions", positions)
    if array.ndim <= 1:
        array = np.stack([np.atleast_1d(array), np.zeros(array.size)], axis=1)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(
            "positions must be places along the lap [m], or pairs along and across it, got shape "
            f"{array.shape}"
        )
    if len(np.unique(array, axis=0)) != len(array):
        raise InputError("positions must differ from bolt to bolt, got one twice")
    return array.copy()


def each_bolt(name: str, value: ArrayLike, count: int, unit: str) -> Floats:
    """A number above zero for each bolt."""
    array = floats(name, value)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise InputError(
            f"{name} must be one number [{unit}], or one for each of the {count} bolts, got shape "
            f"{array.shape}"
        )
    for item in array:
        positive(name, number(name, item, unit), unit)
    return array.copy()
