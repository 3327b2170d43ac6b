"""Face specified by a drawing: rms height and slope, or a machining process."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

from microslip._core.options import option
from microslip._core.units import PRESSURE, engineering, significant
from microslip.contact import DrawnFace, NormalLaw
from microslip.contact.drawn import SHAPE_ERROR, SHAPE_FACTOR, STIFFNESS_ERROR
from microslip.contact.finish import Estimated, Finish, combined
from microslip.study.fields import MATERIALS, POSITIVE_AREA, UNCERTAIN_LENGTH, one_of, scalar
from microslip.study.part import Part, SubTable, SurfaceTable, key, optional_key, tag
from microslip.study.readers import KeyedError, Place
from microslip.study.uncertain import Spread, Uncertain
from microslip.surfaces.options import DIRECTION, PROCESS_NAMES, RA, RQ, RZ

if TYPE_CHECKING:
    from microslip.contact.materials import MaterialPair

_UNTIGHTENED = 1e4
"""Default tightening pressure [Pa], below usual loads, which then tighten the face themselves."""
_FACTOR = Uncertain(scalar("1.0", above=0.0))
_SLOPE = Uncertain(scalar("0.1", above=0.0, most=1.0))
_DRAWN = ("ra", "rq", "rz", "rdq", "rsm", "process")


class _Drawing(Part):
    """Roughness of one face as stated on a drawing."""

    rq: float | None = optional_key(Uncertain(RQ), "Root mean square height Rq.")
    ra: float | None = optional_key(Uncertain(RA), "Arithmetic mean height Ra, instead of Rq.")
    rz: float | None = optional_key(Uncertain(RZ), "Mean peak-to-valley height Rz, instead of Rq.")
    rdq: float | None = optional_key(
        _SLOPE,
        "Rms slope Rdq of profiles; if absent, estimated from the height, with a wide range.",
    )
    rsm: float | None = optional_key(
        UNCERTAIN_LENGTH, "Mean width of the profile elements RSm, instead of Rdq.", '"60 um"'
    )
    process: str | None = optional_key(
        one_of(*PROCESS_NAMES),
        "Machining process, which gives a range of heights if no height is given.",
    )

    @property
    def finish(self) -> Finish:
        values: dict[str, Any] = {}
        for name in _DRAWN:
            value = getattr(self, name)
            values[name] = float(value) if isinstance(value, float) else value
        return Finish(**values)

    def check(self, place: Place) -> None:
        _ = self.finish  # raises an error for values that contradict each other


class SecondFace(_Drawing):
    """Roughness of the opposite face; without this table it is smooth."""


class DrawnSurface(_Drawing, SurfaceTable):
    """Surface specified by a drawing, with contacts that yield."""

    law: str = tag("face", "A face specified by a drawing, with contacts that yield.")
    materials: tuple[str, str] = MATERIALS
    second: SecondFace | None = optional_key(
        SubTable(SecondFace),
        "Roughness of the other face, which is smooth by default.",
        '{ rq = "1 um" }',
    )
    area: float = key(POSITIVE_AREA, "Apparent area.")
    tightening_pressure: float | None = optional_key(
        option("tightening_pressure", "", PRESSURE, example="100 MPa"),
        "Largest mean pressure applied to the face before; by default the pressure of the load.",
    )
    plateau: float | None = optional_key(
        UNCERTAIN_LENGTH, "Rms height Rpq of the plateau of a honed face.", '"0.2 um"'
    )
    breadth: float | None = optional_key(
        scalar("0.84", least=0.6, most=0.95), "Breadth of the spectrum, Rq <q>/h'."
    )
    lay: float | None = optional_key(
        scalar("0.2", above=0.0, most=1.0), "Rms slope along the lay over that across it."
    )
    direction: float | None = key(
        DIRECTION,
        "Direction of motion, from across the lay; by default the mean over all directions.",
    )
    rms_factor: float = key(
        _FACTOR,
        "Factor on Rq; by default drawn for bands if Rq is not exactly known.",
        "1.0",
        default=1.0,
    )
    slope_factor: float = key(
        _FACTOR,
        "Factor on Rdq; by default drawn for bands if Rdq is not exactly known.",
        "1.0",
        default=1.0,
    )
    stiffness_factor: float = key(
        _FACTOR,
        "Factor on the stiffness; by default drawn for bands from the error of the law.",
        "1.0",
        default=1.0,
    )
    shape_factor: float = key(
        _FACTOR, "Factor on the energy of small cycles; by default drawn for bands from the error "
        "of the law.", "1.0", default=1.0,
    )  # fmt: skip

    def check(self, place: Place) -> None:
        """Raise an error for a table with neither a scan nor roughness values."""
        if not any(getattr(self, name) is not None for name in ("ra", "rq", "rz", "process")):
            raise KeyedError(
                ".scan", 'missing; write scan = "face.csv", or rq = "0.8 um" (or ra, rz, process)'
            )
        super().check(place)

    @cached_property
    def _estimates(self) -> dict[str, Estimated]:
        """Estimated rms height [m] and rms slope [-] of the gap, with their uncertainties."""
        finishes = [face.finish for face in (self, self.second) if face is not None]
        if len(finishes) == 1:
            return {name: getattr(finishes[0], name) for name in ("rms", "slope")}
        return {name: combined(*(getattr(f, name) for f in finishes)) for name in ("rms", "slope")}

    @property
    def model_spreads(self) -> dict[str, Spread]:
        """Uncertain factors, by key, on the normal law and on Rq and Rdq estimated from a drawing.

        Their scatter is the known error of the law or of the estimate. Their mean is 1, except for
        the energy of small cycles, which is larger for machined faces than for Gaussian ones.
        """
        variation = math.sqrt(math.expm1(SHAPE_ERROR**2))
        mean = SHAPE_FACTOR * math.hypot(1.0, variation)
        found = {
            "stiffness_factor": Spread.about(1.0, STIFFNESS_ERROR),
            "shape_factor": Spread.about(round(mean, 2), round(variation, 2)),
        }
        for name, estimate in self._estimates.items():
            if estimate.spread > 0.0:
                found[f"{name}_factor"] = Spread.about(1.0, estimate.spread)
        return {name: spread for name, spread in found.items() if name not in self._keys_in_file}

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the normal law of the gap between the two faces."""
        names = ("plateau", "breadth", "lay", "direction", "stiffness_factor", "shape_factor")
        values: dict[str, Any] = {name: getattr(self, name) for name in names}
        rms, slope = (self._estimates[name].middle for name in ("rms", "slope"))
        return DrawnFace(
            pair, rms * float(self.rms_factor), slope * float(self.slope_factor), self.area,
            self.tightening_pressure or _UNTIGHTENED, **values,
        )  # fmt: skip

    def sentences(self) -> list[str]:
        """Describe the rms height and the slope with their uncertainty."""
        words = []
        for name, (middle, spread) in self._estimates.items():
            value = engineering(middle, "m") if name == "rms" else significant(middle)
            symbol = {"rms": "Rq", "slope": "Rdq"}[name]
            words.append(f"{symbol} {value}" + (f" ± {100 * spread:.0f} %" if spread else ""))
        return [
            f"surface: {' and '.join(words)} of the gap. Bands include the errors of the law and "
            "of the drawing; where none are shown, a table [uncertainty] adds them. Measure Rdq to "
            "narrow them."
        ]
