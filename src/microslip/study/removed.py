"""Keys and values that studies of earlier versions could have, and what to write instead."""

from __future__ import annotations

import re

REMOVED_KEYS: dict[str, str] = {
    "oscillator": "use ms.Oscillator in Python (docs/oscillator.md)",
    "excitation.load_variation": "use joint.coupled_force in Python (docs/varying-load.md)",
    "excitation.history.normal_load": "use joint.coupled_response in Python (docs/varying-load.md)",
    "structure.bolts.order": "leave it out: settled motion does not depend on the tightening order",
    "structure.bolts.passes": "leave it out: each bolt is tightened to its tension",
}
"""Key as a study writes it, without item numbers (such as ``structure.base``), and its remedy."""

REMOVED_VALUES: dict[tuple[str, str], str] = {
    ("surface.law", "elliptic-summits"): 'use law = "measured" with a scan and direction',
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
