"""The surface of a study that is a face by its drawing: rms height and slope, or a process."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from microslip._core.errors import InputError
from microslip._core.options import option
from microslip._core.units import PRESSURE, engineering, significant
from microslip.contact import DrawnFace, NormalLaw
from microslip.contact.drawn import SHAPE_ERROR, STIFFNESS_ERROR
from microslip.contact.finish import Estimate, Finish, combined
from microslip.study.fields import AREA, MATERIALS, ROUGHNESS, number, one_of
from microslip.study.part import Part, SubTable, SurfaceTable, key, optional_key, tag
from microslip.study.readers import KeyedError, Place
from microslip.study.uncertain import Spread, Unsure
from microslip.surfaces.options import DIRECTION, PROCESSES, RA, RQ, RZ

if TYPE_CHECKING:
    from microslip.contact.materials import MaterialPair

_UNTIGHTENED = 1e4
"""Pressure of tightening [Pa] where none is given: heavier loads tighten the face themselves."""
_FACTOR = Unsure(number("1.0", above=0.0))
_SLOPE = Unsure(number("0.1", above=0.0, most=1.0))
_DRAWN = ("ra", "rq", "rz", "rdq", "rsm", "process")


class _Drawing(Part):
    """Roughness of one face, as a drawing states it."""

    rq: float | None = optional_key(Unsure(RQ), "Root mean square height Rq.")
    ra: float | None = optional_key(Unsure(RA), "Roughness average Ra, in place of Rq.")
    rz: float | None = optional_key(Unsure(RZ), "Mean peak-to-valley height Rz, in place of Rq.")
    rdq: float | None = optional_key(
        _SLOPE, "Rms slope Rdq of profiles; open within the correlations of slopes if absent."
    )
    rsm: float | None = optional_key(
        ROUGHNESS, "Mean width of the profile elements RSm, in place of Rdq.", '"60 um"'
    )
    process: str | None = optional_key(
        one_of(*PROCESSES),
        "Machining process: a range of heights where none is given.",
    )

    @property
    def finish(self) -> Finish:
        """Rms height and slope with their spreads."""
        values: dict[str, Any] = {}
        for name in _DRAWN:
            value = getattr(self, name)
            values[name] = float(value) if isinstance(value, float) else value
        return Finish(**values)

    def check(self, place: Place) -> None:
        """Refuse here whatever a finish refuses."""
        try:
            self.finish  # noqa: B018
        except InputError as error:
            name = error.argument
            if name in _DRAWN and getattr(self, name) is not None:
                raise KeyedError(f".{name}", error.statement) from None
            raise KeyedError("", error.text) from None


class SecondFace(_Drawing):
    """The other face; without it that face is smooth."""


class DrawnSurface(_Drawing, SurfaceTable):
    """A face by its drawing, with contacts that yield."""

    law: str = tag("face", "A face by its drawing, with contacts that yield.")
    materials: tuple[str, str] = MATERIALS
    second: SecondFace | None = optional_key(
        SubTable(SecondFace),
        "Roughness of the other face; it is smooth if absent.",
        '{ rq = "1 um" }',
    )
    area: float = key(AREA, "Apparent area.")
    tightening_pressure: float | None = optional_key(
        option("tightening_pressure", "", PRESSURE, example="100 MPa"),
        "Largest mean pressure that the face has borne; its load if absent.",
    )
    plateau: float | None = optional_key(
        ROUGHNESS, "Rms height Rpq of the plateau of a honed face.", '"0.2 um"'
    )
    breadth: float | None = optional_key(
        number("0.84", least=0.6, most=0.95), "Breadth of the spectrum, Rq <q>/h'."
    )
    lay: float | None = optional_key(
        number("0.2", above=0.0, most=1.0), "Slope along the lay over that across it."
    )
    direction: float | None = key(
        DIRECTION, "Direction of motion from across the lay; the mean over all if absent."
    )
    rms_factor: float = key(
        _FACTOR, "Factor on Rq; bands draw what the drawing leaves open.", "1.0", default=1.0
    )
    slope_factor: float = key(
        _FACTOR, "Factor on Rdq; bands draw what the drawing leaves open.", "1.0", default=1.0
    )
    stiffness_factor: float = key(
        _FACTOR, "Factor on the stiffness; bands draw the error of the law.", "1.0", default=1.0
    )
    shape_factor: float = key(
        _FACTOR, "Factor on what small cycles lose; bands draw the error of the law.", "1.0",
        default=1.0,
    )  # fmt: skip

    def check(self, place: Place) -> None:
        """Refuse a table with neither a scan nor a drawing."""
        if not any(getattr(self, name) is not None for name in ("ra", "rq", "rz", "process")):
            raise KeyedError(
                ".scan", 'missing; wanted a scan, or rq = "0.8 um", ra, rz or process of a drawing'
            )
        super().check(place)

    @cached_property
    def _estimates(self) -> dict[str, Estimate]:
        """Rms height and slope of the gap, with the spreads that the drawing leaves open."""
        finishes = [face.finish for face in (self, self.second) if face is not None]
        if len(finishes) == 1:
            return {name: getattr(finishes[0], name) for name in ("rms", "slope")}
        return {name: combined(*(getattr(f, name) for f in finishes)) for name in ("rms", "slope")}

    @property
    def model_spreads(self) -> dict[str, Spread]:
        """Errors of the law, and what the drawing leaves open, by the key they are drawn at."""
        errors = {"stiffness_factor": STIFFNESS_ERROR, "shape_factor": SHAPE_ERROR}
        errors |= {f"{name}_factor": found.spread for name, found in self._estimates.items()}
        return {
            name: Spread.about(1.0, error)
            for name, error in errors.items()
            if error > 0.0 and name not in self._keys_in_file
        }

    def build(self, pair: MaterialPair) -> NormalLaw:
        """The law of both faces together."""
        names = ("plateau", "breadth", "lay", "direction", "stiffness_factor", "shape_factor")
        values: dict[str, Any] = {name: getattr(self, name) for name in names}
        rms, slope = (self._estimates[name].middle for name in ("rms", "slope"))
        return DrawnFace(
            pair, rms * float(self.rms_factor), slope * float(self.slope_factor), self.area,
            self.tightening_pressure or _UNTIGHTENED, **values,
        )  # fmt: skip

    def sentences(self) -> list[str]:
        """Describe the rms height and the slope, and what the drawing leaves open."""
        words = []
        for name, (middle, spread) in self._estimates.items():
            value = engineering(middle, "m") if name == "rms" else significant(middle)
            symbol = {"rms": "Rq", "slope": "Rdq"}[name]
            words.append(f"{symbol} {value}" + (f" ± {100 * spread:.0f} %" if spread else ""))
        return [
            f"surface: {' and '.join(words)} of the gap. What a drawing leaves open is drawn by "
            "bands; measure Rdq to narrow them."
        ]
