"""Bolts of a lap joint: where they sit, what they are, and the tension that tightening gives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, positive
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import parameter, parameters_of
from microslip.errors import InputError
from microslip.materials import Material


def _size(symbol: str, meaning: str, example: float) -> dict[str, Any]:
    return parameter(symbol, "m", meaning, above=0.0, example=example)


def _friction(symbol: str, meaning: str) -> dict[str, Any]:
    return parameter(symbol, meaning=meaning, above=0.0, example=0.12)


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
    shank: float = field(metadata=_size("d_s", "diameter of the shanks", 0.008))
    hole: float = field(metadata=_size("d_h", "diameter of the holes", 0.009))
    washer: float = field(
        metadata=_size("d_w", "outer diameter of the washers, or of the heads", 0.017)
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
        default=None, metadata=_size("d", "nominal diameter of the thread, for a torque", 0.008)
    )
    nut_factor: float | None = field(
        default=None,
        metadata=parameter(
            "K", meaning="K of torque = K d tension, 0.2 for dry steel", above=0.0, example=0.2
        ),
    )
    pitch: float | None = field(
        default=None, metadata=_size("P", "pitch of the thread, with two frictions", 0.00125)
    )
    thread_friction: float | None = field(
        default=None, metadata=_friction("mu_G", "friction in the thread")
    )
    bearing_friction: float | None = field(
        default=None, metadata=_friction("mu_K", "friction under the turned head or nut")
    )
    head: float | None = field(
        default=None,
        metadata=_size("k", "height of a head and of a nut, each with its washer", 0.007),
    )
    material: Material | None = None
    density: float | None = field(
        default=None,
        metadata=parameter("rho", "kg/m^3", "mass density of the bolts", above=0.0, example=7850.0),
    )

    def __post_init__(self) -> None:
        assign(self, positions=lock(_places(self.positions)))
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
            assign(self, head=0.8 * self.shank)
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
