"""What each law tells an identification: one class a law."""

from __future__ import annotations

import re
from typing import Any

from microslip._core.checks import show
from microslip.errors import InputError
from microslip.friction.bouc_wen import BoucWen
from microslip.friction.interface import Interface
from microslip.friction.iwan import Iwan
from microslip.friction.jenkins import Jenkins
from microslip.friction.segalman import SegalmanIwan
from microslip.friction.surface_guesses import conventional_radius
from microslip.identification.models.base import (
    BackboneModel,
    Branch,
    CycleModel,
    Derived,
    Model,
    Parameter,
)
from microslip.identification.models.bouc_wen import BoucWenModel
from microslip.identification.models.interface import InterfaceModel
from microslip.identification.models.iwan import IwanModel
from microslip.identification.models.jenkins import JenkinsModel
from microslip.identification.models.segalman import SegalmanModel
from microslip.identification.models.template import template_of

__all__ = [
    "MODELS",
    "BackboneModel",
    "Branch",
    "CycleModel",
    "Derived",
    "Model",
    "Parameter",
    "conventional_radius",
    "model_of",
    "template_of",
]

MODELS: tuple[type[Model], ...] = (
    InterfaceModel,
    JenkinsModel,
    IwanModel,
    SegalmanModel,
    BoucWenModel,
)
"""Every model; the shared tests run over it."""

_LAWS: tuple[type, ...] = (Interface, Jenkins, Iwan, SegalmanIwan, BoucWen)
"""The law of each of them."""


_JOINTS = r"[\s_\-\u2010-\u2015\u2212]+"
"""What may stand between the words of a name: a space, an underscore, any hyphen or dash."""


def model_of(law: Any, **options: Any) -> Model:
    """The model of a law.

    Parameters
    ----------
    law : str, type, law or Model
        "interface", "jenkins", "iwan", "segalman" or "bouc-wen"; the class of the law; or an
        instance, which gives the values to start from, an Interface also the shape of its heights,
        the reference load [N], materials and area [m^2].
    **options
        For an interface ``heights`` or ``surface``, the shape, and ``reference_load`` [N]; for
        Iwan's model ``cells``, their number.

    Returns
    -------
    Model
        What :func:`microslip.identify` fits.

    Raises
    ------
    InputError
        Another law, or an option that the law does not take.
    """
    known = ", ".join(repr(model.name) for model in MODELS)
    if isinstance(law, Model):
        if options:
            raise InputError(f"law must be a name to take options, got a model and {set(options)}")
        return law
    found = None
    if isinstance(law, str):
        asked = re.sub(_JOINTS, "-", law.strip().casefold())
        found = next((m for m in MODELS if m.name == asked), None)
        if found is None:
            raise InputError(f"law must be one of {known}, got {show(law)}")
    else:
        for model, kind in zip(MODELS, _LAWS, strict=True):
            if law is kind or type(law) is kind:
                found = model
        if found is None:
            raise InputError(
                f"law must be one of {known}, the class or an instance of one of these laws, got "
                f"{show(law)}"
            )
    given = not isinstance(law, (str, type))
    takes = () if given else found.options
    unknown = [name for name in options if name not in takes]
    if unknown:
        whose = f"the instance of {type(law).__name__}" if given else f"{found.name!r}"
        says = f"only {' and '.join(takes)}" if takes else "none"
        raise InputError(f"{unknown[0]} is no option of {whose}, which takes {says}")
    return found.of(law) if given else found.made(**options)
