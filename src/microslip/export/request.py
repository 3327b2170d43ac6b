"""Validated request for an export, and the accuracy of the file over a range of amplitudes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean
from microslip._version import __version__
from microslip.export.backbone_panels import BackbonePanels, LoadPanels
from microslip.friction import (
    BackboneLaw,
    Interface,
    IsotropicField,
    IsotropicJoint,
    Iwan,
    JointField,
)
from microslip.friction.conversions import check_not_rigid
from microslip.friction.field_backbone import FieldBackbone
from microslip.friction.memory import SliderBank

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")
_AMPLITUDES = 400  # at which errors are evaluated
Files = dict[str, str | bytes]
"""Content of exported files by name."""
ELEMENTS = ("opensees", "calculix")
"""Kinds of files that consist of elements and can hold a field of patches."""
CODE = ("c", "abaqus-user", "fmu3")
"""Kinds of files that consist of code and support every element of :data:`COMPONENTS`."""
COMPONENTS = ("joint", "contact", "planar", "planar-contact")
"""Displacement components of one element of exported code: one or two tangential, and the
separation."""


@dataclass(frozen=True)
class Accuracy:
    """Errors of an exported file with respect to its law over a range of amplitudes."""

    smallest_amplitude: float
    """Smallest amplitude [m]."""
    largest_amplitude: float
    """Largest amplitude [m]."""
    backbone_error: float
    """Largest relative error of the backbone [-]."""
    energy_error: float
    """Largest relative error of the energy dissipated per cycle [-]."""

    @classmethod
    def of(
        cls,
        law: BackboneLaw,
        span: tuple[float, float],
        backbone: Callable[[Floats], Floats],
        energy: Callable[[Floats], Floats],
    ) -> Accuracy:
        """Return the largest errors of ``backbone`` and ``energy`` with respect to ``law``.

        ``backbone`` (force [N]) and ``energy`` (dissipated per cycle [J]) are functions of the
        amplitude [m] as the exported file computes them, compared over the range ``span`` [m].
        """
        a = np.geomspace(*span, _AMPLITUDES)
        force, lost = law._backbone(a), law._energy(a)
        real = lost > 0.0
        energy_errors = np.abs(energy(a)[real] / lost[real] - 1.0)
        force_error = float(np.max(np.abs(backbone(a) / force - 1.0)))
        return cls(*span, force_error, float(np.max(energy_errors, initial=0.0)))


@dataclass(frozen=True)
class Patch:
    """Law of one patch of the contact, and the numbers of its two mesh nodes; () if not given."""

    law: BackboneLaw
    nodes: tuple[int, ...]


@dataclass(frozen=True)
class Order:
    """Validated request for an export."""

    kind: str
    run: str
    patches: tuple[Patch, ...]
    element: str
    model: Any
    span: tuple[float, float]
    cells: int
    depth: int
    size: int
    name: str
    direction: int
    first_number: int
    stem: str
    suffix: str
    described: str

    @property
    def law(self) -> BackboneLaw:
        """Law of the first patch, the only one except in files of elements."""
        return self.patches[0].law

    @cached_property
    def panels(self) -> BackbonePanels:
        """Backbone as piecewise polynomials."""
        return BackbonePanels.of(self.law, self.span[0])

    @cached_property
    def load_panels(self) -> LoadPanels:
        """Load curve of a contact element as piecewise polynomials."""
        if isinstance(self.model, IsotropicField):
            return LoadPanels.of_field(self.model)
        return LoadPanels.of_interface(self.model)

    @property
    def bank(self) -> SliderBank | None:
        """Sliders of an element with two tangential directions, else None."""
        return self.model._bank if self.element.startswith("planar") else None

    @cached_property
    def cell_models(self) -> tuple[Iwan, ...]:
        """Iwan models, one per patch, each fitted to the law of its patch."""
        low, high = self.span
        span = {"smallest_amplitude": low, "largest_amplitude": high}
        return tuple(patch.law.to_iwan(self.cells, **span) for patch in self.patches)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Accuracy of the file: largest errors of all patches."""
        if self.kind in ELEMENTS:
            fits = [model.fit[:2] for model in self.cell_models if model.fit]
            return Accuracy(*self.span, *map(max, zip(*fits, strict=True)))
        if self.bank is not None:  # errors of motion along a line
            bank = self.bank
            reach = (bank.tops - bank.rests[0]) * bank.slips[0]
            reach, weights = np.maximum(reach, 0.0), bank.weights * (bank.scales / bank.slips)[0]
            return Accuracy.of(
                self.law,
                self.span,
                lambda u: np.minimum(u[:, None], reach) @ weights,
                lambda u: 4.0 * np.maximum(u[:, None] - reach, 0.0) @ (reach * weights),
            )
        panels = self.panels if self.element == "joint" else self.load_panels
        return Accuracy.of(self.law, self.span, panels.force, panels.energy)

    def header(self) -> list[str]:
        """Return the header of each file, line by line, in SI units."""
        errors = self.accuracy
        low, high = errors.smallest_amplitude, errors.largest_amplitude
        lines = [
            f"Written by microslip {__version__}, kind {self.kind}. Units: m, N, J.",
            f"Law: {self.described}",
            f"Amplitudes: {low:.6g} m to {high:.6g} m.",
            f"Largest error over them, backbone {errors.backbone_error:.2g}, "
            f"energy of a cycle {errors.energy_error:.2g} (relative).",
        ]
        if self.kind in ELEMENTS:
            count = sum(model.cell_count for model in self.cell_models)
            lines.append(f"{count} cells of spring and slider in {len(self.patches)} patch(es).")
        lines.append(f"Verification: {self.run}.")
        return [short for line in lines for short in wrap(line, 96, subsequent_indent="  ")]


def element_of(
    kind: str, law: Any, element: str, cells: int, span: dict[str, Any]
) -> tuple[str, Any, Any]:
    """Check ``element`` for the kind and law; return its name, the exported law and a reference.

    The exported law has as many directions as the element; for two directions it consists of
    ``cells`` sliders, which for ``planar`` elements are fitted over the amplitudes in ``span`` [m].
    The reference is a law in one direction, with which the exported law is compared in motion along
    a straight line, for the errors of the export.
    """
    check_word("element", element, COMPONENTS)
    if kind not in CODE:
        if element != "joint":
            raise InputError(
                f"`element` must be joint for {kind}, got {element}; "
                f"the other elements need {', '.join(CODE)}"
            )
        return element, law, law
    if element in ("contact", "planar-contact") and not isinstance(
        law, (Interface, IsotropicField)
    ):
        raise InputError(f"{element} elements need an Interface, got {show(law)}")
    if element == "planar" and isinstance(law, BackboneLaw):
        law = IsotropicJoint(law, cells, **span)
    elif element == "planar-contact" and isinstance(law, Interface):
        law = JointField(
            law.surface,
            law.friction_coefficient,
            areas=1.0,
            separations=law.separation,
            surface_area=1.0,
        ).two_directions(cells)
    if isinstance(law, IsotropicJoint):
        return "planar", law, law.joint
    if isinstance(law, IsotropicField):
        if law._bank.lay is not None:
            raise InputError(
                f"{kind} supports one stiffness in all directions, and the surface has a lay; use "
                "its mean, surface.along(None)"
            )
        if law.field._nodes.size != 1:
            raise InputError(
                f"{kind} supports one node, got {law.field._nodes.size}; write one file per node"
            )
        nodes, separation = law.field._nodes, float(law.field.separations[0])
        friction = float(nodes.weights[0] / nodes.scales[0])
        scale = float(nodes.scales[0])
        line = JointField(
            nodes.curve.surface, friction, areas=scale, separations=separation, surface_area=1.0
        )
        return "planar-contact", law, line.rigid()
    return element, law, law


def checked_patches(kind: str, law: Any, nodes: ArrayLike | None) -> tuple[Patch, ...]:
    """Validate the law and its mesh nodes; return the patches that carry a load."""
    laws = _laws(kind, law)
    if nodes is None:
        if len(laws) > 1:
            raise InputError(
                f"`nodes` must be given for a field, two numbers per patch [{len(laws)} patches], "
                "got none"
            )
        return (Patch(laws[0], ()),)
    if kind not in ELEMENTS:
        raise InputError(
            f"`nodes` must not be given for {kind}, which has no mesh; kinds with a "
            f"mesh are {', '.join(ELEMENTS)}"
        )
    pairs = np.atleast_2d(np.asarray(nodes))
    if (
        pairs.shape != (len(laws), 2)
        or pairs.dtype.kind not in "iuf"
        or not np.all((pairs >= 1) & (pairs < 1e9) & (pairs == np.floor(pairs)))
        or np.any(pairs[:, 0] == pairs[:, 1])
    ):
        raise InputError(
            "`nodes` must be two different node numbers, 1 or larger, for each of "
            f"{len(laws)} patch(es), for example nodes=[[1, 2]]; got {show(nodes)}"
        )
    return tuple(
        Patch(item, (int(a), int(b)))
        for item, (a, b) in zip(laws, pairs.tolist(), strict=True)
        if item is not None
    )


def _laws(kind: str, law: Any) -> list[Any]:
    if isinstance(law, BackboneLaw):
        check_not_rigid(law, f"files of kind {kind}")
        return [law]
    if isinstance(law, JointField):
        if kind not in ELEMENTS:
            raise InputError(
                f"{kind} supports one law, got a field of patches; use "
                f"{', '.join(ELEMENTS)}, or the law of patches that move together, field.rigid()"
            )
        if not law.normal_loads.any():
            raise InputError("`law` must have a patch that carries a load, got none")
        return _laws_of_field(law)
    if isinstance(law, (IsotropicJoint, IsotropicField)):
        raise InputError(
            f"{kind} supports one direction, and {type(law).__name__} has two; use "
            f"{', '.join(CODE)}"
        )
    raise InputError(f"`law` must be a backbone law, such as an Interface or Iwan, got {show(law)}")


def _laws_of_field(field: JointField) -> list[BackboneLaw | None]:
    nodes = field._nodes
    return [
        FieldBackbone(
            nodes.curve, nodes.weights[i : i + 1], nodes.slips[i : i + 1], nodes.rests[i : i + 1],
            float(limit),
        )
        if limit > 0.0
        else None
        for i, limit in enumerate(field.force_limits)
    ]  # fmt: skip


def described(law: Any) -> str:
    """Describe a law or a field in one line."""
    surface = getattr(law, "surface", None)
    under = f", on {surface!r}" if surface is not None else ""
    if isinstance(law, JointField):
        return f"a field of {law.size} patches{under}"
    limit, stiffness = exact(law.force_limit), exact(law.tangential_stiffness)
    return f"{law!r}{under}; force limit {limit} N, stiffness at rest {stiffness} N/m"


def check_word(name: str, value: Any, words: Iterable[str]) -> None:
    """Raise InputError unless a value is one of the allowed words."""
    words = tuple(words)
    if not isinstance(value, str) or value not in words:
        near = did_you_mean(value, words) if isinstance(value, str) else ""
        raise InputError(f"`{name}` must be one of {', '.join(words)}, got {show(value)}{near}")


def check_name(name: Any) -> None:
    """Raise InputError unless a value is allowed as the beginning of names in files."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise InputError(
            "`name` must begin with a letter and have up to 31 letters, digits and _, as C and "
            f'Fortran require, for example name="joint"; got {show(name)}'
        )
