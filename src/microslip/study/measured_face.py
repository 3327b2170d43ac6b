"""Face measured by a scan, solved point by point by boundary elements."""

from __future__ import annotations

from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from microslip._core.checks import Progress
from microslip._core.errors import InputError
from microslip._core.options import option
from microslip._core.parameters import JsonSchema
from microslip._core.quantities import named
from microslip._core.units import PRESSURE, engineering
from microslip._core.wording import quote, shorten
from microslip.contact import MeasuredContact, NormalLaw
from microslip.study.fields import MATERIALS, text
from microslip.study.part import SurfaceTable, tag
from microslip.study.part import key as key_of
from microslip.study.readers import KeyedError, Place, Reader
from microslip.surfaces import options

if TYPE_CHECKING:
    from microslip.contact.materials import MaterialPair
    from microslip.contact.measured_face import ContactNumbers
    from microslip.surfaces import Scan

TIGHTENING_OPTION = option(
    "tightening_pressure",
    "Mean pressure to which the face was tightened, with contacts that yield; larger loads are "
    "rejected. By default the largest normal load over the area, or the pressure under the "
    "washers.",
    PRESSURE,
    example="100 MPa",
    metavar="PRESSURE",
)
PIECE = option(
    "piece",
    'Approximate side of the pieces in which the scan is solved, in points; "none" for the whole.',
    int,
    default=256,
    least=16,
    none="none",
    metavar="POINTS",
)
COARSER = option(
    "coarser",
    "Also solve with every second point and without the shortest waves, and report the changes.",
    bool,
    default=False,
)


class _Channel(Reader):
    """Reader of a channel of an instrument file, given by name or number."""

    help, example, default = options.CHANNEL.help, options.CHANNEL.example_text, None

    def read(self, raw_value: object, place: Place) -> str | int:
        if isinstance(raw_value, bool) or not isinstance(raw_value, (str, int)) or raw_value == "":
            raise ValueError(f'wanted a channel such as "Topography" or 0, got {quote(raw_value)}')
        return raw_value

    def schema(self) -> JsonSchema:
        return {"anyOf": [{"type": "string"}, {"type": "integer"}]}


def _single(values: Any) -> Any:
    return values[0] if values and len(values) == 1 else values


class MeasuredFace(SurfaceTable):
    """Surface measured by a scan and solved point by point, with contacts that yield."""

    cutoff: float | None = key_of(options.CUTOFF.but(default=None))
    long_cutoff: float | None = key_of(options.LONG_CUTOFF)
    crop: tuple[float, ...] | None = key_of(options.CROP)
    level: str | None = key_of(options.LEVEL)
    format: str | None = key_of(options.FORMAT)
    unit: tuple[str, ...] | None = key_of(options.UNIT)
    pixel: tuple[float, ...] | None = key_of(options.PIXEL)
    channel: str | int | None = key_of(_Channel())
    valid: tuple[float, ...] | None = key_of(options.VALID, example='["-1 mm", "1 mm"]')
    law: str = tag("face", "A scan solved point by point, with contacts that yield.")
    materials: tuple[str, str] = MATERIALS
    scan: str = key_of(
        text("the name of a scan", "ground.plu"),
        "File of the scan, relative to the folder of the study.",
    )
    tightening_pressure: float | None = key_of(TIGHTENING_OPTION)
    direction: float | None = key_of(
        options.DIRECTION,
        help="Direction of motion, from x of the scan towards y; by default the mean over all "
        "directions.",
    )
    area: float | None = key_of(options.SCAN_AREA)
    piece: int | None = key_of(PIECE)
    coarser: bool = key_of(COARSER)

    read_scan: Scan
    """Scan as read and cropped, with spikes removed and missing points filled."""

    _law: MeasuredContact | None = None
    _own_tightening: bool = False  # by the load of the joint or the bolts
    _patch: float | None = None  # side of the patches of a structure [m]

    def check(self, place: Place) -> None:
        """Read the scan; raise an error if it is a profile."""
        from microslip.surfaces import Scan

        name, here = shorten(self.scan, 100), place.path(self.scan)
        try:
            scan = Scan.read(
                here,
                self.format,
                unit=_single(self.unit),
                pixel=_single(self.pixel),
                channel=self.channel,
                valid=None if self.valid is None else (self.valid[0], self.valid[1]),
            )
            if scan.is_profile:
                raise KeyedError(
                    ".scan",
                    "wanted an areal scan, got a profile, which cannot be solved point by point",
                )
            scan = scan.repaired().condition(crop=self.crop)
        except InputError as error:
            message = " ".join(str(error).split()).replace(str(here), name)
            message = message if message.startswith(name) else f"{name}: {message}"
            if not here.exists():
                message = place.message(message, self.scan)
            raise KeyedError(".scan", message) from None
        notes = " ".join(scan.notes).replace("`", "")
        place.notes.append(f"{place.key}.scan: {notes}")
        self.keep(read_scan=scan)

    @property
    def conditioned(self) -> Scan:
        """Scan without form and long waves, but not yet filtered by the short-wave cut-off."""
        return self.read_scan.condition(**named(self, "level", "long_cutoff"))

    @cached_property
    def face(self) -> Any:
        """Scan after all filters, as it is passed to the contact solver."""
        scan = self.conditioned
        if self._removes_form:
            scan = scan.condition(long_cutoff=self._patch)
        return scan if self.cutoff is None else scan.condition(cutoff=self.cutoff)

    @property
    def _removes_form(self) -> bool:
        """Whether waves longer than a patch of a structure's contact are filtered out of the scan.

        They belong to the key ``structure.form``, the gap between the unloaded faces.
        """
        patch = self._patch
        return patch is not None and self.long_cutoff is None and patch < max(self.read_scan.size)

    def build(
        self, pair: MaterialPair, pressure: float, progress: Progress | None = None
    ) -> NormalLaw:
        """Return the normal law of the face; solutions are cached.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        pressure : float
            Largest mean pressure on the face [Pa], used as tightening pressure if the study has
            none. A face without hardness stays elastic.
        progress : callable, optional
            Called with the completed fraction, 0 to 1.
        """
        report = progress or (lambda share: None)
        tightening, hardness = self.tightening_pressure, pair.hardness
        self._own_tightening = tightening is None and hardness is not None
        if tightening is None and hardness is not None:
            # Patches of a structure have a lower pressure than the ring under a washer.
            tightening = pressure if self._patch is None else min(pressure, 0.5 * hardness)
        self._law = self.face.to_contact(
            pair,
            area=self.area,
            tightening_pressure=tightening,
            **named(self, "direction", "piece", "coarser"),
            progress=lambda done, total: report(done / total),
        )
        return self._law

    @property
    def apparent_area(self) -> float:
        """Apparent area [m^2]; by default that of the scan."""
        return self.area or self.face.area

    def findings(self) -> dict[str, Any]:
        """Return the numbers of the solved face in SI units, for summary.json."""
        scan = self.face
        numbers: dict[str, Any] = {
            "name": scan.name,
            **named(self, "cutoff", "long_cutoff", "direction"),
            "area": scan.area,
            "notes": list(scan.notes),
        }
        if self._law is not None:
            numbers |= asdict(self._law.numbers)
        return {"scan": numbers}

    def sentences(self) -> list[str]:
        """Return sentences on the face: accuracy, tightening, wavelengths that its law includes."""
        name = shorten(Path(self.scan).name, 100)
        cutoff = "" if self.cutoff is None else f", cut-off {engineering(self.cutoff, 'm')}"
        start = f"surface.scan: {name}{cutoff}, solved point by point"
        if self._law is None:
            return [start + "."]
        from microslip.surfaces.joints import contact_words  # loads SciPy

        numbers = self._law.numbers
        return [f"{start}: {contact_words(numbers)}.", *self._tightened_by(numbers), *self._split()]

    def _tightened_by(self, numbers: ContactNumbers) -> list[str]:
        """Describe the source of the tightening pressure if the study does not give it."""
        if numbers.hardness is None:
            return [
                "surface: the materials have no hardness, so the face stays elastic; write "
                "material.<name>.hardness for contacts that yield."
            ]
        if not self._own_tightening:
            return []
        source = "the largest normal load over the area tightens the face"
        if self._patch is not None:
            source = "bolts press the face under their washers; each patch is tightened by its own"
        pressure = engineering(numbers.pressure, "Pa")
        return [f"surface.tightening_pressure: absent, {pressure} is used: {source}."]

    def _split(self) -> list[str]:
        """Describe which wavelengths belong to the normal law and which to ``structure.form``."""
        patch = self._patch
        if patch is None:
            return []
        size = max(self.read_scan.size)
        ends = f"surface.scan: waves up to {engineering(min(patch, size), 'm')} are in the law"
        if self.long_cutoff is not None:
            ends = f"surface.scan: waves up to {engineering(self.long_cutoff, 'm')} are in the law"
            return [f"{ends} (surface.long_cutoff); patches are {engineering(patch, 'm')} wide."]
        if self._removes_form:
            off = float(np.std(self.conditioned.heights - self.face.heights))
            return [
                f"{ends}; waves longer than a patch, {engineering(off, 'm')} rms of the scan, are "
                "form, and are in the model only if structure.form includes them."
            ]
        return [
            f"{ends}, the size of the scan. Waves between this size and the side of a patch, "
            f"{engineering(patch, 'm')}, are not modelled; longer ones belong to structure.form."
        ]
