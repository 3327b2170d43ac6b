"""A bolted lap joint from its drawing."""

from __future__ import annotations

from dataclasses import dataclass, field

from microslip._core.checks import exact
from microslip._core.errors import InputError
from microslip.structures.beam_mesh import Lap, Style, declared_length
from microslip.structures.bolted_beam import Drawing
from microslip.structures.bolts import Bolts


@dataclass(frozen=True, eq=False)
class LapJoint(Drawing):
    """Two beams or plates, bolted where they overlap.

    The lap is centred at the origin and lies in the plane z = 0: x runs along the joint, y across,
    z upwards. In the lap the left part is the lower one. Both ends are free. For several laps, or
    ends bolted to the ground, see :class:`BoltedBeam`.

    Parameters
    ----------
    length : float
        Total length, from end to end [m].
    width : float
        Width, across [m].
    thickness : float
        Thickness of the parts outside the lap [m].
    lap : float
        Length of the overlap [m].
    bolts : Bolts
        Bolts through the overlap.
    style : {"half-lap", "single-lap"}
        In a half lap each part is half as thick in the overlap, so that the whole is straight; in
        a single lap whole plates lie on each other.

    Notes
    -----
    Elements and reduction: :meth:`reduce`, after Craig and Bampton (1968, DOI 10.2514/3.4741).

    Examples
    --------
    >>> import microslip as ms
    >>> bolts = ms.Bolts([-0.03, 0.0, 0.03], shank=0.008, hole=0.009, washer=0.018, tension=12e3)
    >>> ms.LapJoint(length=0.72, width=0.025, thickness=0.025, lap=0.12, bolts=bolts).style
    'half-lap'
    """

    length: float = field(metadata=declared_length("L", "length from end to end", 0.72))
    width: float = field(metadata=declared_length("b", "width, across", 0.0254))
    thickness: float = field(
        metadata=declared_length("t", "thickness of each part outside the lap", 0.0254)
    )
    lap: float = field(metadata=declared_length("l", "length of the overlap", 0.12))
    bolts: Bolts
    style: Style = "half-lap"

    _names = ("left", "right")

    def __post_init__(self) -> None:
        self._check()
        if not self.lap < self.length:
            raise InputError(
                f"lap must be shorter than the length {exact(self.length)} m, got "
                f"{exact(self.lap)} m"
            )

    @property
    def laps(self) -> tuple[Lap, ...]:  # type: ignore[override]
        """Single lap of the joint."""
        return (Lap(0.0, self.lap, self.bolts),)
