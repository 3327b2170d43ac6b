"""Bolts in results: forces from tightening to service."""

from __future__ import annotations

from typing import Any

from microslip._core.units import engineering
from microslip.structures.bolt_tightening import BoltForces, tension_band


def force_rows(forces: BoltForces | None) -> list[tuple[str, str]]:
    """Return rows on the forces of a bolt, from tightening to service; none if they are unknown."""
    if forces is None:
        return []
    low, high = tension_band(forces.tightening_factor)
    tightened = engineering(forces.assembly, "N", 4)
    if high > low:
        ends = " to ".join(engineering(end * forces.assembly, "N", 4) for end in (low, high))
        tightened += f", {ends} by a tightening factor of {forces.tightening_factor:g}"
    rows = [("Tension after tightening", tightened)]
    if forces.utilisation is not None:
        rows.append(("Stress of tightening", f"{forces.utilisation:.2f} of the proof stress"))
    if forces.embedding:
        lost = f"{engineering(forces.loss, 'N', 3)} at an embedding of"
        rows.append(("Lost after tightening", f"{lost} {engineering(forces.embedding, 'm', 3)}"))
    if forces.clamping != forces.assembly:
        left = engineering(forces.clamping, "N", 4)
        if high > low:
            left += ", " + " to ".join(engineering(end, "N", 4) for end in forces.ends)
        rows.append(("Clamp force between the plates, per bolt", left))
    return rows


def force_numbers(forces: BoltForces | None) -> dict[str, Any] | None:
    """Return the forces of a bolt as plain values in SI units."""
    if forces is None:
        return None
    return {**vars(forces), "clamping": forces.clamping, "clamping_range": list(forces.ends)}
