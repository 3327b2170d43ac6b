"""Models of an identification: by the metadata of a law's class, or by a class of their own."""

from __future__ import annotations

import inspect
import math
import re
from typing import Any

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip._core.parameters import parameters_of, says_all
from microslip.contact import NormalLaw, SphereOnFlat
from microslip.friction.base import BackboneLaw
from microslip.friction.interface import Interface
from microslip.friction.iwan import Iwan
from microslip.friction.laws import LAWS
from microslip.identification.models.base import Branch, Derived, Model
from microslip.identification.models.interface import InterfaceModel
from microslip.identification.models.law import IwanModel, LawModel
from microslip.identification.models.sphere import GivenSurfaceModel, SphereModel
from microslip.identification.models.surface_shape import template_of

__all__ = [
    "MODELS",
    "Branch",
    "Derived",
    "LawModel",
    "Model",
    "model_of",
    "template_of",
]

_SPECIAL: dict[type, type[Model]] = {
    Interface: InterfaceModel,
    Iwan: IwanModel,
}
"""Laws that need more than their parameters: a surface, a grid."""


def _model(kind: Any) -> Model | None:
    """The model of a class of laws; None for one that cannot be fitted."""
    if kind in _SPECIAL:
        return _SPECIAL[kind].create()
    if not (inspect.isclass(kind) and issubclass(kind, BackboneLaw)):
        return None
    if not says_all(kind) or any(item.many for item in parameters_of(kind)):
        return None
    rigid = any(math.isinf(law.tangential_stiffness) for law in kind.examples())
    return None if rigid else LawModel(kind)


MODELS: tuple[Model, ...] = (
    *(model for model in map(_model, LAWS) if model is not None),
    SphereModel(),
)
"""The model of every exported law that can be fitted; the shared tests run over it."""


def _given_surface_model(surface: Any = None, **options: Any) -> Model:
    """The model of a surface that is known, given by its option."""
    if not isinstance(surface, NormalLaw) or options:
        raise InputError(
            f"`law` {GivenSurfaceModel.name!r} needs `surface=...`, a surface with its "
            f"materials, and nothing else, got {show(surface)}"
        )
    return GivenSurfaceModel(surface)


_JOINTS = r"[\s_\-\u2010-\u2015\u2212]+"
"""Separators between the words of a name: a space, an underscore, any hyphen or dash."""


def model_of(law: Any, **options: Any) -> Model:
    """The model of a law."""
    if isinstance(law, Model):
        if options:
            raise InputError(
                f"`law` must be a name to take options, got a model and {set(options)}"
            )
        return law
    is_instance = not isinstance(law, (str, type))
    if isinstance(law, Interface) and isinstance(law.surface, SphereOnFlat) and not options:
        return SphereModel.of(law)
    if isinstance(law, str):
        key = re.sub(_JOINTS, "-", law.strip().casefold())
        if key == GivenSurfaceModel.name:
            return _given_surface_model(**options)
        model = next((model for model in MODELS if model.name == key), None)
    else:
        model = _model(type(law) if is_instance else law)
    if model is None:
        names = ", ".join(repr(candidate.name) for candidate in MODELS)
        alternatives = (
            "" if isinstance(law, str) else ", the class or an instance of a law that declares its "
        )
        alternatives += "parameters" if alternatives else ""
        raise InputError(f"`law` must be one of {names}{alternatives}, got {show(law)}")
    takes = () if is_instance else model.options
    for name in options:
        if name not in takes:
            whose = f"the instance of {type(law).__name__}" if is_instance else f"{model.name!r}"
            accepted = f"only {' and '.join(takes)}" if takes else "none"
            raise InputError(f"{name} is no option of {whose}, which takes {accepted}")
    if is_instance:
        return model.of(law)
    return model.create(**options) if options else model
