"""Keys and values that studies of earlier versions could have, and what to write instead."""

from __future__ import annotations

import re

REMOVED_KEYS: dict[str, str] = {
    "joint.law": 'leave it out for an interface, or write law_file = "law.json", which '
    "microslip.friction.save_law writes (docs/study.md)",
    "oscillator": "use ms.Oscillator in Python (docs/oscillator.md)",
    "excitation.load_variation": "use joint.coupled_force in Python (docs/varying-load.md)",
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
    "surface.fill": "leave it out: missing points of a scan are filled",
    "surface.outliers": "leave it out: spikes of a scan are removed; others by "
    "ms.Scan.condition(outliers=...) in Python",
    "surface.key": 'write channel = "z", which also names the array of a file',
    "surface.skewness": 'give RoughSurface the measured heights in Python, or use law = "face"',
    "surface.kurtosis": 'give RoughSurface the measured heights in Python, or use law = "face"',
    "uncertainty.scan_patches": 'use law = "face", whose pieces are resampled',
    "structure.bolts.order": "leave it out: settled motion does not depend on the tightening order",
    "structure.bolts.passes": "leave it out: each bolt is tightened to its tension",
}
"""Key as a study writes it, without item numbers (such as ``structure.base``), and its remedy."""

REMOVED_VALUES: dict[tuple[str, str], str] = {
    ("surface.law", "measured"): 'write law = "face" with the same keys',
    ("surface.law", "elliptic-summits"): 'use law = "face" with a scan and direction',
    ("surface.law", "persson"): 'use law = "face" with a scan, or law = "rough" without one',
    ("surface.law", "scan"): 'use law = "face", the scan point by point',
    ("surface.law", "drawing"): 'use law = "rough" with ra or rq, roll_off and shortest',
    ("surface.law", "two-faces"): 'use law = "face" with a scan of the gap, or law = "rough"',
}
"""Key and value as a study writes them (such as ``("surface.law", "persson")``), and the remedy."""

_ITEM_NUMBER = re.compile(r", item \d+")


def removed_key(key: str) -> str | None:
    """Return the message for a key that earlier versions accepted, or None."""
    remedy = REMOVED_KEYS.get(_ITEM_NUMBER.sub("", key))
    return f"removed in 0.3; {remedy}" if remedy else None


def removed_value(key: str, value: str) -> str | None:
    """Return the message for a value that earlier versions accepted, or None."""
    remedy = REMOVED_VALUES.get((_ITEM_NUMBER.sub("", key), value))
    return f'"{value}" was removed in 0.3; {remedy}' if remedy else None
