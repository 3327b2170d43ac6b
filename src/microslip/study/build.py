"""Construction of the surface and joints of a study, and samples of its uncertain values."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, Progress
from microslip._core.errors import InputError, StudyError
from microslip.contact import MeasuredContact, NormalLaw
from microslip.contact.materials import MaterialPair
from microslip.friction import Interface
from microslip.study.consistency import check_consistency
from microslip.study.description import StudyDescription
from microslip.study.drawn_face import DrawnSurface
from microslip.study.joints import Joint
from microslip.study.measured_face import MeasuredFace
from microslip.study.readers import KeyedError, as_keyed
from microslip.study.schema import GROUPS, UncertaintyPart
from microslip.study.uncertain import (
    at_central_values,
    changed,
    spreads_of,
    with_values,
)


def build_surface(study: StudyDescription, progress: Progress | None = None) -> NormalLaw:
    """Return the normal law of a study; solving a scan point by point takes seconds or more."""
    if study._law is not None:
        return study._law
    materials = {}
    for name, material in study.material.items():
        with naming_key(study, f"material.{name}", material.keys):
            materials[name] = material.build()
    surface = study.surface
    assert surface is not None  # an interface has one
    with naming_key(study, "surface.materials"):
        first, second = surface.materials
        pair = MaterialPair(materials[first], materials[second])
    how: dict[str, Any] = {}
    if isinstance(surface, MeasuredFace):
        if study.structure is not None:
            surface._patch = study.structure.patch_size
        how = {"progress": progress, "pressure": _largest_pressure(study, surface)}
    with naming_key(study, "surface", surface.keys):
        law: NormalLaw = surface.build(pair, **how)
    pressure = getattr(study.joint, "pressure", None)
    if isinstance(surface, DrawnSurface) and surface.tightening_pressure is None and pressure:
        with naming_key(study, "joint.pressure"):  # bolts tighten before their joint embeds
            law = law._under(pressure.largest(pressure.tightening or 0.0) * surface.area)
    return law


def _largest_pressure(study: StudyDescription, surface: MeasuredFace) -> float:
    """Return an upper bound of the mean pressure on the face [Pa], its default tightening pressure.

    For bolts it is their tension over the area between hole and washer rim, rounded up to a power
    of 1.25 so that samples with other tensions use the same solution.
    """
    if study.structure is not None:
        part = study.structure
        ring = min(
            0.25 * math.pi * (washer[2] ** 2 - hole[2] ** 2)
            for washer, hole in zip(part.washers, part.holes, strict=True)
        )
        return float(1.25 ** math.ceil(math.log(float(part.tension.max()) / ring, 1.25)))
    assert isinstance(study.joint, Joint)
    largest, pressure = max(map(float, study.joint.normal_load)), study.joint.pressure
    if pressure is None:
        return largest / surface.apparent_area
    return pressure.largest(pressure.tightening or largest)  # bolts tighten before they embed


def build_joints(study: StudyDescription, progress: Progress | None = None) -> list[Interface]:
    """Return the joints of a study, one per normal load; or its friction law alone, if given."""
    if not isinstance(study.joint, Joint):
        return [cast(Interface, study.joint.build())]
    surface = build_surface(study, progress)
    joints: list[Interface] = []
    loads = study.joint.normal_load
    # Loads above the tightening load tighten the face further: each load gets a law of its own, so
    # that results do not depend on the order of the loads.
    alike = max(loads, default=0.0) <= surface._heaviest
    for index, load in enumerate(loads, start=1):
        item = f", item {index}" if len(loads) > 1 else ""
        with naming_key(study, f"joint.normal_load{item}"):
            if joints and alike:
                joint: Any = joints[0].at(normal_load=load)
            else:
                joint = study.joint.build(surface if alike else surface._under(load), load)
            joints.append(cast(Interface, joint))
    return joints


@contextmanager
def naming_key(study: StudyDescription, key: str, names: Container[str] = ()) -> Iterator[None]:
    """Return a context that turns an InputError into a StudyError about a key of the study.

    If the error is about an argument in ``names``, the name of the argument is appended to ``key``.
    """
    try:
        yield
    except InputError as error:
        key, message = as_keyed(error, key, names)
        raise StudyError(f"{study.name}: {key}: {message}") from error


_REPLICATES = 4096  # bootstrap replicates of the pieces of a scan


@dataclass(frozen=True)
class Input:
    """Uncertain number: its key, and its distribution in words."""

    key: str
    written: str


class Design:
    """Map from standard normal scores of the uncertain inputs to a study with fixed numbers.

    A row of scores has one column for each input. If the surface is a scan that was divided into
    pieces, a last column selects a bootstrap sample of the pieces.
    """

    def __init__(self, study: StudyDescription) -> None:
        study = with_model_spreads(study)
        self.study = study
        self.part = study.uncertainty or UncertaintyPart.of()
        self.spreads = dict(spreads_of(study))
        self.inputs = [Input(key, spread.written) for key, spread in self.spreads.items()]
        self._pieces = self._drawn_pieces()
        if self._pieces is not None:
            count = self._pieces.shape[1]
            self.inputs.append(Input("surface.scan", f"{count} pieces, resampled together"))

    def _drawn_pieces(self) -> NDArray[np.intp] | None:
        """Return bootstrap samples of the pieces of a scan, shape (samples, pieces).

        Each row is a sample: indices of pieces. Rows are sorted by their normal stiffness per
        pressure under the largest load. None if the surface is not a scan or has a single piece.
        """
        if not isinstance(self.study.surface, MeasuredFace):
            return None
        law = build_surface(at_central_values(self.study))
        assert isinstance(law, MeasuredContact)
        p, s = law.solution.pressure[0], law.solution.slope[0]
        if p.size < 2:
            return None
        rng = np.random.default_rng([self.part.seed, 19])
        rows = rng.integers(0, p.size, (_REPLICATES, p.size))
        order = np.argsort(s[rows].mean(axis=1) / p[rows].mean(axis=1), kind="stable")
        return np.asarray(rows[order])

    def scores(self, points: Floats) -> Floats:
        """Return normal scores for points in the unit cube, shape (points, inputs)."""
        from scipy.special import ndtri

        return np.asarray(ndtri(np.clip(points, 2.0**-33, 1.0 - 2.0**-33)))

    def values(self, shares: Floats) -> dict[str, float]:
        """Return the uncertain numbers by key, at cumulative probabilities ``shares``."""
        return {
            key: float(spread.quantiles(shares[i : i + 1])[0])
            for i, (key, spread) in enumerate(self.spreads.items())
        }

    def at(self, scores: Floats) -> StudyDescription:
        """Return the study for one row of normal scores, shape (inputs,)."""
        from scipy.special import ndtr

        shares = ndtr(scores)
        study: StudyDescription = with_values(self.study, self.values(shares))
        if self._pieces is not None:
            row = min(int(shares[len(self.spreads)] * _REPLICATES), _REPLICATES - 1)
            law = build_surface(study)
            assert isinstance(law, MeasuredContact)
            study._law = law.of_pieces(self._pieces[row])
        return study

    def points(self, samples: int | None = None, count: int = GROUPS) -> Floats:
        """Return scrambled Sobol' points in the unit cube, shape (groups, points, inputs)."""
        from scipy.stats import qmc

        size = 2 ** max(3, math.ceil(math.log2((samples or self.part.samples) / count)))
        groups = []
        for group in range(count):
            rng = np.random.default_rng([self.part.seed, group])
            sobol = qmc.Sobol(len(self.inputs), scramble=True, rng=rng)
            groups.append(sobol.random(size))
        return np.array(groups)


def with_model_spreads(part: Any) -> Any:
    """Return a study or table with known model errors (``model_spreads``) as uncertain inputs."""
    spreads = getattr(part, "model_spreads", None)
    part = changed(part, lambda value, key: with_model_spreads(value))
    return part.copy(**spreads) if spreads else part


def is_uncertain(study: StudyDescription) -> bool:
    """Return whether any input is uncertain, or [uncertainty] adds the errors of the surface."""
    if study.uncertainty is not None:
        study = with_model_spreads(study)
    return next(spreads_of(study), None) is not None


def check_draws(study: StudyDescription) -> None:
    """Raise an error for samples of the uncertain inputs that are invalid, before the run."""
    if study.structure is not None or not is_uncertain(study):
        return
    design = Design(study)
    from scipy.special import ndtr

    refused: list[KeyedError] = []
    points = np.concatenate(design.points())
    for scores in design.scores(points):
        values = design.values(ndtr(scores))
        draw = with_values(study, values)
        try:
            check_consistency(
                draw.copy(uncertainty=None)
            )  # the sample has no uncertain numbers left
        except KeyedError as error:
            refused.append(error)
    if refused:
        first = refused[0]
        raise StudyError(
            f"{study.name}: {first.key}: {len(refused)} of {len(points)} draws cannot be "
            f"predicted; the first error: {first}; narrow the uncertain inputs"
        )
