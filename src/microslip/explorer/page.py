"""The page of the explorer: its script with the tables and limits of the package in it."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from microslip import kernels
from microslip._version import __version__
from microslip.friction.validity import RULES
from microslip.materials import metals
from microslip.numerics.quadrature import gauss_legendre
from microslip.report.html import script

_FOLDER = Path(__file__).parent
_NODES = 20


@dataclass(frozen=True)
class Quantity:
    """A number that can be chosen: where its slider ends, and what a box takes [SI]."""

    key: str
    group: str
    label: str
    unit: str
    scale: float
    start: float
    range: tuple[float, float]
    valid: tuple[float, float]
    log: bool = True


def _bodies() -> tuple[Quantity, ...]:
    parts = []
    for number, group in ((1, "first"), (2, "second")):
        parts += [
            Quantity(f"e{number}", group, "E", "GPa", 1e9, 69e9, (1e9, 500e9), (1e3, 1e13)),
            Quantity(
                f"nu{number}", group, "ν", "", 1.0, 0.33, (0.0, 0.5), (-0.999, 0.5), log=False
            ),
        ]
    return tuple(parts)


QUANTITIES = (
    *_bodies(),
    Quantity("std", "surface", "Roughness σ", "µm", 1e-6, 5e-7, (1e-8, 2e-5), (1e-12, 1e-2)),
    Quantity("radius", "surface", "Summit radius", "µm", 1e-6, 1e-3, (1e-6, 1e-2), (1e-9, 1.0)),
    Quantity("density", "surface", "Summits", "1/mm²", 1e6, 1e8, (1e6, 1e12), (1.0, 1e18)),
    Quantity("area", "surface", "Area", "cm²", 1e-4, 2e-4, (1e-6, 1e-2), (1e-12, 1e2)),
    Quantity("mu", "joint", "Friction μ", "", 1.0, 0.55, (0.05, 1.5), (1e-6, 1e3), log=False),
    Quantity("load", "joint", "Normal load", "N", 1.0, 2000.0, (1.0, 1e5), (1e-9, 1e9)),
    Quantity("amplitude", "joint", "Amplitude", "µm", 1e-6, 3e-7, (1e-9, 1e-4), (1e-14, 1e-1)),
)
"""What can be chosen; it begins as the worked example of the chapter's joint."""


def law_script() -> str:
    """The joint in closed form as JavaScript, with the tables of the kernel."""
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
    """The whole page: HTML that needs a browser and nothing else."""
    table = {
        metal.name: {
            "description": metal.description,
            "e": metal.young_modulus,
            "nu": metal.poisson_ratio,
            **({} if metal.hardness is None else {"hardness": metal.hardness}),
        }
        for metal in metals().values()
    }
    constants = {"FIELDS": [vars(quantity) for quantity in QUANTITIES], "METALS": table}
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
    """Constants as JavaScript that cannot close the script it stands in."""
    lines = []
    for name, value in values.items():
        text = json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
        lines.append(f"const {name} = {text};\n")
    return "".join(lines)
