"""Keys and values of earlier versions, with their replacements."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Any

from microslip._core.units import LENGTH, significant, to_si
from microslip.contact.finish import GAUSSIAN_RQ

REMOVED_KEYS: dict[str, str] = {
    "joint.law": 'leave it out for an interface, or write law_file = "law.json", which '
    "microslip.friction.save_law writes (docs/study.md)",
    "oscillator": "use ms.Oscillator in Python (docs/oscillator.md)",
    "excitation.load_variation": "use joint.coupled_force in Python (docs/varying-load.md)",
    "excitation.history.time": "leave it out: the figure is drawn over the samples; draw "
    "others from the arrays of result.nc",
    "excitation.history.normal_load": "use joint.coupled_response in Python (docs/varying-load.md)",
    "structure.base": "use ReducedJoint.on_base and base_response in Python "
    "(examples/19_shaker_table.py)",
    "structure.random": "use ReducedJoint.on_base and random_response in Python "
    "(examples/20_random_vibration.py)",
    "structure.shock": "use ReducedJoint.on_base and shock in Python (examples/21_shock.py)",
    "structure.geometry": "use ReducedJoint.with_geometry in Python (examples/22_panel.py)",
    "structure.laps": "use ms.BoltedBeam in Python (examples/18_several_laps.py)",
    "structure.ground": "use ms.BoltedBeam in Python (examples/18_several_laps.py)",
    "structure.rise": "use ms.BoltedBeam in Python (examples/22_panel.py)",
    "structure.masses": "use masses= of LapJoint.reduce or MeshedJoint.reduce in Python",
    "structure.materials": "use ms.BoltedBeam in Python (examples/18_several_laps.py)",
    "structure.densities": "use ms.BoltedBeam in Python (examples/18_several_laps.py)",
    "surface.limit": "leave it out; use ms.Scan.read(..., limit=...) in Python for larger scans",
    "surface.fill": "leave it out: missing points of a scan are filled",
    "surface.outliers": "leave it out: spikes of a scan are removed",
    "surface.key": 'write channel = "z", which also names the array of a file',
    "surface.filter": "leave it out: long waves are removed by a Gaussian filter; for "
    "other filters use SurfaceTopography or the software of the instrument",
    "surface.hardness": "write hardness of the material, [material.NAME]",
    "joint.tightening_load": "write tightening_pressure, the load over the area, in a [surface] "
    'with law = "face"; summits stay elastic',
    "joint.yield_stress": "write hardness of the material, 2.84 times the yield stress",
    "joint.tightening_model": "leave it out: faces yield at the hardness of their material",
    "uncertainty.scan_patches": 'use law = "face", whose pieces are resampled',
    "surface.heights.file": 'write values = { file = "heights.csv", column = "y [um]" }',
    "surface.heights.column": 'write values = { file = "heights.csv", column = "y [um]" }',
    "uncertainty.identification": "use the joint.toml that identify writes: it carries the "
    "intervals of the law",
    "uncertainty.correlations": "leave it out: inputs are drawn independently; for correlated "
    "inputs use ms.evaluate over your own samples in Python",
    "uncertainty.indices": "use scipy.stats.sobol_indices over ms.evaluate in Python",
    "uncertainty.method": "leave it out: the points are scrambled Sobol' points",
    "not_identified": "leave it out: the joint.toml that identify writes includes intervals",
    "structure.bolts.order": "leave it out: settled motion does not depend on the tightening order",
    "joint.pressure.axial_load": "write preload, the tension minus (1 - Phi) times the load, with "
    "Phi of ClampedBolt.load_factor in Python (docs/bolted-structures.md)",
    "joint.pressure.load_factor": "write preload, the tension minus (1 - Phi) times the axial load",
    "structure.bolts.slack": "leave a loose bolt out of the positions, or out of the bolts of a "
    "mesh with a cut shank",
    "structure.form.x": "name the columns of the file x, y and gap",
    "structure.form.y": "name the columns of the file x, y and gap",
    "structure.form.gap": "name the columns of the file x, y and gap",
    "structure.measured.amplitude": "name the column of the file amplitude",
    "structure.measured.frequency": "name the column of the file frequency",
    "structure.measured.damping_ratio": "name the column of the file damping_ratio",
    "structure.bolts.passes": "leave it out: each bolt is tightened to its tension",
}
"""Replacements by key, such as ``structure.base``, without item numbers."""

REMOVED_VALUES: dict[tuple[str, str], str] = {
    ("surface.heights.kind", "scipy"): 'write kind = "table" with the density of the distribution, '
    "or use ms.GreenwoodWilliamson in Python (docs/materials-and-heights.md)",
    ("surface.law", "measured"): 'write law = "face" with the same keys',
    ("surface.law", "elliptic-summits"): 'use law = "face" with a scan and direction',
    ("surface.law", "scan"): 'write law = "face" with the same scan, solved point by point',
    ("surface.law", "rough"): 'write law = "face" with rq or ra, and rdq',
    ("surface.law", "persson"): 'write law = "face" with rq and rdq, or with a scan',
    ("surface.law", "drawing"): 'write law = "face" with the same ra, rq, rz, rsm and process',
    ("surface.law", "two-faces"): 'write law = "face" with ra or rq, rsm or rdq of one face, and '
    "second = { ra = … } of the other",
    ("joint.pressure.kind", "parabola"): 'write kind = "patches", with areas of rings',
    ("joint.pressure.kind", "table"): 'write kind = "patches", with areas of rings',
}
"""Replacements by key and value, such as ``("surface.law", "persson")``."""

_ITEM_NUMBER = re.compile(r", item \d+")


def removed_key(key: str) -> str | None:
    """Return the error message for a key of an earlier version, or None for other keys."""
    remedy = REMOVED_KEYS.get(_ITEM_NUMBER.sub("", key))
    return None if remedy is None else f"removed in 0.3; {remedy}"


def removed_value(
    key: str, value: str, table: Mapping[str, Any] = MappingProxyType({})
) -> str | None:
    """Return the error message for a value of an earlier version, or None for other values.

    The message contains converted numbers if ``table`` contains all values needed for them.
    """
    remedy = REMOVED_VALUES.get((_ITEM_NUMBER.sub("", key), value))
    if remedy is None:
        return None
    # Without the necessary numbers, or with uncertain ones, nothing is converted.
    with suppress(KeyError, TypeError, ValueError, ArithmeticError, StopIteration):
        remedy = _face_by_spectrum(value, table) or remedy
    return f'"{value}" was removed in 0.3; {remedy}'


def _face_by_spectrum(law: str, table: Mapping[str, Any]) -> str | None:
    """Return a message with the keys of a drawn face that replace the removed ``law`` of a surface.

    The keys give the same rms height and rms slope. None for laws without a spectrum.
    """
    if law not in ("rough", "persson") or "spectrum" in table:
        return None
    name = next(name for name in ("rq", "ra", "rms") if name in table)
    rms: float = _length(table[name]) * (GAUSSIAN_RQ if name == "ra" else 1.0)
    if (slope := table.get("slope")) is None:
        roll_off = _length(table.get("roll_off", table.get("longest")))
        longest = _length(table["longest"]) if "longest" in table else roll_off
        sizes = longest, roll_off, _length(table["shortest"])
        slope = significant(_rms_slope(rms, float(table.get("hurst", 0.8)), *sizes))
    kept = [f"area = {json.dumps(table['area'])}"] if "area" in table else []
    height = "ra" if name == "ra" else "rq"
    keys = [f"{height} = {json.dumps(table[name], ensure_ascii=False)}", f"rdq = {slope}", *kept]
    return f'write law = "face" with {", ".join(keys)}, in place of its waves'


def _rms_slope(rms: float, hurst: float, longest: float, roll_off: float, shortest: float) -> float:
    """Return the rms slope [-] of a self-affine surface with a flat spectrum at long waves.

    ``longest``, ``roll_off`` and ``shortest`` are wavelengths [m].
    """
    low, middle, high = (2.0 * math.pi / size for size in (longest, roll_off, shortest))
    if not low <= middle < high:
        raise ValueError

    def moment(n: int) -> float:
        """Return the integral of q^(n + 1) times the spectral density over wavenumber q."""
        steep = math.pow(middle, -2.0 - 2.0 * hurst)
        flat = steep * (middle ** (n + 2) - low ** (n + 2)) / (n + 2)
        power = n - 2.0 * hurst
        if abs(power) < 1e-9:
            return flat + math.log(high / middle)
        return flat + (math.pow(high, power) - math.pow(middle, power)) / power

    return rms * math.sqrt(0.5 * moment(2) / moment(0))


def _length(value: Any) -> float:
    return to_si(value, LENGTH, "1 um")
