"""What the ring-down and the envelope of an oscillator ask of it."""

from __future__ import annotations

from typing import Any, Literal, Protocol

from microslip.friction import BackboneLaw


class Swinging(Protocol):
    """A mass on a spring that a joint holds too, as :class:`microslip.Oscillator` is one."""

    @property
    def mass(self) -> float:
        """Mass [kg]."""

    @property
    def stiffness(self) -> float:
        """Stiffness of the spring [N/m]."""

    @property
    def joint(self) -> BackboneLaw:
        """What holds it, too."""

    @property
    def viscous_coefficient(self) -> float:
        """Viscous damping [N s/m]."""

    def angular_frequency(
        self,
        amplitude: Any,
        *,
        method: Literal["quasi-static", "harmonic-balance"] = "quasi-static",
    ) -> Any:
        """Natural frequency at amplitudes [rad/s]."""

    @property
    def _stuck(self) -> float: ...
