"""Floor 8: `summary.json`, everything but the long columns, with keys that say what they hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from microslip._kernel_choice import kernel_name
from microslip._version import __version__
from microslip.study import surfaces as u
from microslip.study.result import UNITS, AmplitudeCurve, Limits
from microslip.study.schema import Study
from microslip.study.units import engineering

if TYPE_CHECKING:
    from microslip.friction import Interface

KIND = "microslip-result"
SUMMARY_SCHEMA = 1
REMINDER = (
    "Loss factor and damping ratio are the interface's own. In a structure the damping ratio of a "
    "mode is the sum of the energies of its joints over 4 pi times the energy of the whole mode."
)


@dataclass(frozen=True)
class Defaults:
    """Which amplitudes the study leaves open, and the slip scale [m] they are then taken from."""

    scale: float
    meaning: str
    amplitudes: bool
    curve: bool
    factors: tuple[float, ...]
    range: tuple[float, float]

    def notes(self) -> list[str]:
        """What was assumed, in sentences."""
        scale = engineering(self.scale, "m", trim=True)
        of = f"times the slip scale, {scale} when rounded to two digits"
        notes = []
        if self.amplitudes:
            factors = ", ".join(f"{factor:g}" for factor in self.factors)
            notes.append(f"excitation.amplitudes is not given: {factors} {of}.")
        if self.curve:
            low, high = self.range
            notes.append(f"excitation.curve is not given: {low:g} to {high:g} {of}.")
        return notes


def slip_scale(study: Study, joint: Interface) -> tuple[float, str]:
    """Displacement over which the joint goes from sticking to sliding.

    Parameters
    ----------
    study : Study
        Gives the heights.
    joint : Interface
        The joint at one load.

    Returns
    -------
    tuple of float and str
        The scale [m] and how it is defined: the slip per indentation times the standard deviation
        (or mean, for exponential heights) where there is one, else the force limit over the
        stiffness at rest.
    """
    heights = getattr(study.surface, "heights", None)
    if isinstance(heights, u.GaussianHeights):
        return joint.slip_per_indentation * heights.std, "slip_per_indentation * heights.std"
    if isinstance(heights, u.ExponentialHeights):
        return joint.slip_per_indentation * heights.scale, "slip_per_indentation * heights.scale"
    return joint.force_limit / joint.tangential_stiffness, "force_limit / tangential_stiffness"


def files(study: Study) -> tuple[str, ...]:
    """Names of the files that a study writes."""
    formats = study.output.formats
    pictures = [kind for kind in ("svg", "png") if kind in formats]
    return (
        "summary.json",
        *(("study.toml",) if study.text is not None else ()),
        *(("loops.csv", "curves.csv") if "csv" in formats else ()),
        *(f"{name}.{kind}" for name in ("loops", "energy_damping") for kind in pictures),
    )


def summarise(
    study: Study,
    joints: Sequence[Interface],
    rows: Sequence[AmplitudeCurve],
    limits: Sequence[Limits],
    defaults: Defaults,
    names: Sequence[str],
) -> dict[str, Any]:
    """Contents of `summary.json`.

    Parameters
    ----------
    study : Study
        The study.
    joints, rows, limits : sequence
        For each load the joint, its quantities at the amplitudes and its limits.
    defaults : Defaults
        What the study leaves open.
    names : sequence of str
        The files of the result.

    Returns
    -------
    dict
        Plain values only: `kind` and `schema` mark a result and its version, `generator` names
        program, version and kernel, `study` echoes the input in SI units, `notes` says what was
        assumed, `joints` holds one entry for each load, `units` the unit of every number and
        `files` what lies beside the summary.
    """
    return {
        "kind": KIND,
        "schema": SUMMARY_SCHEMA,
        "generator": {"name": "microslip", "version": __version__, "kernel": kernel_name()},
        "title": study.title,
        "study": study.model_dump(mode="json", by_alias=True, exclude_none=True),
        "notes": [*defaults.notes(), *_title_notes(study, names), REMINDER],
        "joints": [
            _joint(study, joint, row, limit)
            for joint, row, limit in zip(joints, rows, limits, strict=True)
        ],
        "units": dict(UNITS),
        "files": list(names),
    }


def _title_notes(study: Study, names: Sequence[str]) -> list[str]:
    pictures = any(name.endswith((".svg", ".png")) for name in names)
    if not pictures or study.title.isascii():
        return []
    from microslip.study.drawing import missing_glyphs

    missing = missing_glyphs(study.title)
    return [f"title: the figures have no letters for {missing} and draw boxes."] if missing else []


def _joint(study: Study, joint: Interface, row: AmplitudeCurve, limit: Limits) -> dict[str, Any]:
    scale, meaning = slip_scale(study, joint)
    area = getattr(study.surface, "area", None)
    contact = joint.contact_area
    columns = row.columns()
    return {
        "normal_load": _plain(joint.normal_load),
        "separation": _plain(joint.separation),
        "standardised_separation": _standardised(study, joint),
        "contact_count": _plain(joint.contact_count),
        "contact_area": _plain(contact),
        "contact_area_fraction": _plain(contact / area if contact is not None and area else None),
        "normal_stiffness": _plain(joint.normal_stiffness),
        "tangential_stiffness": _plain(joint.tangential_stiffness),
        "force_limit": _plain(joint.force_limit),
        "slip_per_indentation": _plain(joint.slip_per_indentation),
        "slip_scale": _plain(scale),
        "slip_scale_meaning": meaning,
        "limits": {
            "cubic_coefficient": _plain(limit.cubic_coefficient),
            "linear_offset": _plain(limit.linear_offset),
        },
        "amplitudes": [
            {name: _plain(values[index]) for name, values in columns.items()}
            for index in range(len(row.amplitude))
        ],
        "validity": [
            {
                "name": verdict.name,
                "value": _plain(verdict.value),
                "limit": _plain(verdict.limit),
                "word": verdict.word,
                "meaning": verdict.meaning,
            }
            for verdict in joint.validity
        ],
    }


def _standardised(study: Study, joint: Interface) -> float | None:
    heights = getattr(study.surface, "heights", None)
    if isinstance(heights, u.GaussianHeights):
        return float((joint.separation - heights.mean) / heights.std)
    if isinstance(heights, u.ExponentialHeights):
        return float(joint.separation / heights.scale)
    return None


def _plain(value: Any) -> float | None:
    """A Python float, or None for what is not known: JSON has no NaN."""
    if value is None or not math.isfinite(value):
        return None
    return float(value)
