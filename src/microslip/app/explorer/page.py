"""HTML page of the explorer: script, with tables and limits computed by the package."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core import kernels
from microslip._core.parameters import Number, parameter_of
from microslip._core.quadrature import gauss_legendre
from microslip._core.units import LARGEST, SMALLEST
from microslip._version import __version__
from microslip.contact import GreenwoodWilliamson
from microslip.contact.heights import Gaussian
from microslip.contact.materials import Material, metals
from microslip.contact.validity import RULES
from microslip.figures.picture import script
from microslip.friction import Interface

_FOLDER = Path(__file__).parent
_NODES = 20


def _input(
    key: str, group: str, declared: Number, start: float, ends: tuple[float, float]
) -> dict[str, Any]:
    """Describe the input field of a declared number as a dict, which the script of the page reads.

    ``key`` is the name of the input, ``group`` the part of the page that contains it. ``start`` is
    its initial value, and ``ends`` is the range of its slider, both in SI units.
    """
    scale, unit = declared.written_unit(start)
    low = declared.least if math.isfinite(declared.least) else declared.above
    return {
        "key": key,
        "group": group,
        "label": declared.heading,
        "unit": unit.replace("um", "µm").replace("^2", "²"),
        "scale": scale,
        "start": start,
        "range": ends,
        # Excluded bounds are replaced by the nearest admissible number.
        "valid": (
            math.nextafter(max(low, -LARGEST), math.inf) if low else SMALLEST,
            min(declared.most, declared.below, LARGEST),
        ),
        "log": bool(unit) and declared.is_positive,
    }


def _inputs() -> Iterator[dict[str, Any]]:
    modulus, ratio = (parameter_of(Material, name) for name in ("young_modulus", "poisson_ratio"))
    for number, group in ((1, "first"), (2, "second")):
        yield _input(f"e{number}", group, modulus, 69e9, (1e9, 500e9))
        yield _input(f"nu{number}", group, ratio, 0.33, (0.0, 0.5))
    spread = parameter_of(Gaussian, "std").but(meaning="roughness σ")
    yield _input("std", "surface", spread, 5e-7, (1e-8, 2e-5))
    for name, start, ends in (
        ("radius", 1e-3, (1e-6, 1e-2)), ("density", 1e8, (1e6, 1e12)), ("area", 2e-4, (1e-6, 1e-2)),
    ):  # fmt: skip
        yield _input(name, "surface", parameter_of(GreenwoodWilliamson, name), start, ends)
    friction, load = (parameter_of(Interface, n) for n in ("friction_coefficient", "normal_load"))
    yield _input("mu", "joint", friction, 0.55, (0.05, 1.5))
    yield _input("load", "joint", load, 2000.0, (1.0, 1e5))
    amplitude = Number("amplitude", "a", "m", "amplitude", above=0.0)
    yield _input("amplitude", "joint", amplitude, 3e-7, (1e-9, 1e-4))


INPUTS = tuple(_inputs())


def law_script() -> str:
    """Return JavaScript that computes the joint in closed form, with coefficients of F_n.

    The coefficients are those of :func:`microslip._core.kernels.gaussian_moment`.
    """
    nodes, weights = gauss_legendre(_NODES)
    rules = {
        rule.name: {"watch": rule.watch, "outside": rule.outside, "meaning": rule.meaning}
        for rule in RULES
    }
    path = Path(kernels.__file__).with_name("gaussian_moments.npy")
    tables = np.load(path, allow_pickle=False).astype("<f8")
    text = base64.b64encode(tables.tobytes()).decode("ascii")
    decoded = f'new Float64Array(Uint8Array.from(atob("{text}"), (c) => c.charCodeAt(0)).buffer)'
    constants = {
        "NODES": nodes.tolist(),
        "WEIGHTS": weights.tolist(),
        "RULES": rules,
    }
    return (
        f"const TABLES = {decoded};\n"
        + _constants(constants)
        + _script("law.js")
        + _script("study.js")
    )


def page() -> str:
    """Return the HTML page, which needs no other files."""
    table = {
        metal.name: {
            "description": metal.description,
            "e": metal.young_modulus,
            "nu": metal.poisson_ratio,
            **({} if metal.hardness is None else {"hardness": metal.hardness}),
        }
        for metal in metals().values()
    }
    constants = {"FIELDS": INPUTS, "METALS": table}
    parts = {
        "css": (_FOLDER / "explorer.css").read_text(encoding="utf-8"),
        "version": escape(__version__),
        "script": law_script() + _constants(constants) + script("ticks.js") + _script("view.js"),
    }
    text = (_FOLDER / "explorer.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        text = text.replace(f"@{name}@", part)
    return text


def _script(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")


def _constants(values: Mapping[str, object]) -> str:
    """Return JavaScript constants, escaped so that no text ends the script element."""
    lines = []
    for name, value in values.items():
        text = json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
        lines.append(f"const {name} = {text};\n")
    return "".join(lines)
