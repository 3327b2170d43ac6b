"""Bolt of a metric size and grade: permitted tension, tension losses, load factor of an axial load.

After VDI 2230 part 1 (2015), in its own symbols; grades by ISO 898-1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

from microslip._core.checks import exact, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean, quoted
from microslip.friction.pressure import BOLTS, BoltSize

GRADES = MappingProxyType(
    {
        "4.6": 240e6, "5.6": 300e6, "5.8": 420e6, "6.8": 480e6, "8.8": 640e6, "9.8": 720e6,
        "10.9": 940e6, "12.9": 1100e6,
    }
)  # fmt: skip
"""Least yield strength or 0.2 % proof stress [Pa] of each grade (ISO 898-1)."""
TIGHTENING_FACTOR = 1.6
"""Largest over smallest preload at one torque, by a torque wrench with estimated friction."""
_EMBEDDING = ((10e-6, 3.0, 2.5, 1.5), (40e-6, 3.0, 3.0, 2.0), (160e-6, 3.0, 4.0, 3.0))
"""Largest Rz [m], and embedding [um] of the thread, of a bearing face, of an inner interface."""


def size_named(name: object) -> BoltSize:
    """Return the dimensions of a metric bolt size such as M8."""
    if not isinstance(name, str) or name not in BOLTS:
        hint = did_you_mean(name, BOLTS) if isinstance(name, str) else ""
        raise InputError(f"`size` must be {quoted(BOLTS)}, got {show(name)}{hint}")
    return BOLTS[name]


def proof_stress(grade: object, diameter: float) -> float:
    """Return the minimum proof stress [Pa] of a grade; that of 8.8 is 660 MPa above 16 mm."""
    if not isinstance(grade, str) or grade not in GRADES:
        raise InputError(f"`grade` must be {quoted(GRADES)}, got {show(grade)}")
    return 660e6 if grade == "8.8" and diameter > 0.016 else GRADES[grade]


def tension_band(tightening_factor: float) -> tuple[float, float]:
    """Return smallest and largest preload at one tightening torque, relative to their mean [-]."""
    return 2.0 / (1.0 + tightening_factor), 2.0 * tightening_factor / (1.0 + tightening_factor)


@dataclass(frozen=True)
class Thread:
    """Metric thread of 60 degrees (ISO 68-1).

    Parameters
    ----------
    diameter : float
        Nominal diameter d [m].
    pitch : float
        Pitch P [m].
    """

    diameter: float
    pitch: float

    @property
    def pitch_diameter(self) -> float:
        """Pitch diameter d2 = d - 0.6495 P [m]."""
        return self.diameter - 0.375 * math.sqrt(3.0) * self.pitch

    @property
    def core_diameter(self) -> float:
        """Core diameter d3 = d - 1.2269 P [m]."""
        return self.diameter - 17.0 / 24.0 * math.sqrt(3.0) * self.pitch

    @property
    def stress_area(self) -> float:
        """Stress area A_S = pi/4 ((d2 + d3)/2)^2 [m^2], from pitch and core diameter."""
        return 0.25 * math.pi * (0.5 * (self.pitch_diameter + self.core_diameter)) ** 2

    def reduced_stress(self, tension: float, friction: float) -> float:
        """Return the equivalent stress [Pa] of tension and torque during tightening.

        sigma_red = F/A_S sqrt(1 + 3 (3/2 d2/d0 (P/(pi d2) + 1.155 mu_G))^2) for plastic torsion,
        with F = ``tension`` [N], mu_G = ``friction`` [-] and d0 = (d2 + d3)/2 (VDI 2230).
        """
        mean = 0.5 * (self.pitch_diameter + self.core_diameter)
        lead = self.pitch / (math.pi * self.pitch_diameter) + 2.0 / math.sqrt(3.0) * friction
        shear = 1.5 * self.pitch_diameter / mean * lead
        return tension / self.stress_area * math.sqrt(1.0 + 3.0 * shear**2)


@dataclass(frozen=True)
class ClampedBolt:
    """Bolt and nut through plates: resiliences, load factor, embedding.

    Parameters
    ----------
    size : str
        Metric size d of bolt and nut, such as "M8".
    clamp_length : float
        Total thickness l_K of the clamped parts [m].
    plate_modulus : float
        Young's modulus of the plates [Pa].
    modulus : float
        Young's modulus of the bolt [Pa].

    Notes
    -----
    Resiliences by VDI 2230 part 1. The bolt is threaded over the clamp length; the head counts as
    0.5 d of further bolt length, the engaged thread as 0.5 d and the nut as 0.4 d. The plates are
    wide enough for two whole deformation cones. Their half-angle phi is given by tan(phi) = 0.362 +
    0.032 ln(l_K/(2 d_W)) + 0.153 ln(y), where d_W is the bearing diameter and y the ratio of plate
    diameter to d_W, here at its largest value 1 + 1.2 l_K/d_W.
    """

    size: str
    clamp_length: float
    plate_modulus: float = 205e9
    modulus: float = 205e9

    def __post_init__(self) -> None:
        size_named(self.size)
        positive("clamp_length", self.clamp_length, "m", 0.02)
        positive("plate_modulus", self.plate_modulus, "Pa", 205e9)
        positive("modulus", self.modulus, "Pa", 205e9)

    @property
    def resilience(self) -> float:
        """Resilience delta_S of the bolt [m/N]."""
        bolt = size_named(self.size)
        d = bolt.diameter
        full, core = d, Thread(d, bolt.pitch).core_diameter
        areas = [0.25 * math.pi * x**2 for x in (full, core)]
        lengths = 0.9 * d / areas[0] + (self.clamp_length + 0.5 * d) / areas[1]
        return lengths / self.modulus

    @property
    def plate_resilience(self) -> float:
        """Resilience delta_P of the clamped plates [m/N]."""
        bolt, length = size_named(self.size), self.clamp_length
        ratio = length / bolt.head
        slope = 0.362 + 0.032 * math.log(0.5 * ratio) + 0.153 * math.log(1.0 + 1.2 * ratio)
        wide = bolt.head + length * slope
        a, b = bolt.head + bolt.hole, bolt.head - bolt.hole
        c, e = wide - bolt.hole, wide + bolt.hole
        cones = 2.0 * math.log(a * c / (b * e))
        return cones / (self.plate_modulus * math.pi * bolt.hole * slope)

    def load_factor(self, introduction: float = 0.5) -> float:
        """Return Phi = n delta_P/(delta_S + delta_P) [-], the bolt's fraction of an axial load.

        The load introduction factor n is ``introduction`` [-].
        """
        return introduction * self.plate_resilience / (self.resilience + self.plate_resilience)

    def loss(self, embedding: float) -> float:
        """Return F_Z = f_Z/(delta_S + delta_P) [N], the tension lost by embedding f_Z [m]."""
        return embedding / (self.resilience + self.plate_resilience)


def embedding_of(rz: float, interfaces: int = 1) -> float:
    """Return the embedding f_Z [m] of thread and faces of roughness Rz [m] by VDI 2230."""
    rz = positive("rz", rz, "m", 6.3e-6)
    row = next((row for row in _EMBEDDING if rz < row[0]), None)
    if row is None:
        raise InputError(f"`rz` must be below 160 um, where the table ends, got {exact(rz)} m")
    _, thread, bearing, inner = row
    return 1e-6 * (thread + 2.0 * bearing + interfaces * inner)


@dataclass(frozen=True)
class BoltForces:
    """Forces of a bolt from tightening to service, in the symbols of VDI 2230."""

    assembly: float
    """Mean assembly preload F_M [N]."""
    tightening_factor: float = 1.0
    """Tightening factor alpha_A [-]."""
    embedding: float = 0.0
    """Embedding f_Z of all faces together [m]."""
    loss: float = 0.0
    """Tension F_Z lost by embedding [N]."""
    utilisation: float | None = None
    """Tightening stress over the proof stress [-]; None without a grade."""

    @property
    def clamping(self) -> float:
        """Clamp force F_M - F_Z between the plates [N]."""
        return self.assembly - self.loss

    @property
    def ends(self) -> tuple[float, float]:
        """Clamp forces for the smallest and the largest assembly preload [N]."""
        low, high = tension_band(self.tightening_factor)
        return low * self.assembly - self.loss, high * self.assembly - self.loss
