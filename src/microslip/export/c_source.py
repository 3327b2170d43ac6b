"""C99 source of a law, with its header and a Fortran interface.

The functions that follow the history of a joint are those of the compiled kernel: its header files
are copied into the source.
"""

from __future__ import annotations

import re
from importlib.resources import files

import numpy as np

from microslip._core.checks import Floats
from microslip.export.request import Files, Order

_FOLDER = files("microslip.export") / "templates"
_PART = re.compile(r"@IF ([a-z -]+)@\n?(.*?)@END@\n?", re.DOTALL)
_STATIC = re.compile(r"(?m)^static [^;={]*?(\w+)\(")
_TYPE = re.compile(r"(?m)^(?:typedef void |\} )(\w+);")
_CONSTANTS = {"MU", "KAPPA", "SCALE", "REST", "RECIPROCALS"}


def render(name: str, element: str = "joint", **values: object) -> str:
    """Return the text of a template with its placeholders replaced.

    ``name`` is the name of the file without suffix. Each @WORD@ is replaced by the argument WORD,
    and parts between @IF ...@ and @END@ are kept only if they name ``element``.
    """
    text = (_FOLDER / f"{name}.template").read_text(encoding="utf-8")
    text = _PART.sub(lambda part: part[2] if element in part[1].split() else "", text)
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


def comment(lines: list[str], start: str = " * ", first: str = "/*\n", last: str = " */\n") -> str:
    """Format lines as a comment, by default of C."""
    safe = [line.replace("*/", "* /") for line in lines]
    return first + "".join(f"{start}{line}".rstrip() + "\n" for line in safe) + last


def components_of(element: str) -> int:
    """Return the number of displacement components of an element: 1, 2 or 3."""
    return 1 + element.startswith("planar") + element.endswith("contact")


def order_of(element: str) -> str:
    """Describe in words the sequence of the components of motion and force of an element."""
    opening = ["opening of the separation [m]; forces, load [N]"] * element.endswith("contact")
    return ", ".join(
        ["two displacements" if element.startswith("planar") else "displacement", *opening]
    )


def _words(order: Order) -> dict[str, object]:
    element = order.element
    contact = element.endswith("contact")
    words: dict[str, object] = {
        "NAME": order.name, "DEPTH": order.depth, "ORDER": order_of(element),
        "TANGENTIAL": components_of(element) - contact, "COMPONENTS": components_of(element),
        "LEAST": "-1e300", "LOAD_SCALE": "1.0",
        "FRICTION": "1.0", "SLIP": "1.0", "SCALE": "1.0", "REST": "0.0", "ORIGIN": "0.0",
        "AT": "at the committed separation" if contact else "at its normal load",
    }  # fmt: skip
    if contact:
        curve = order.load_panels
        words |= {
            "FRICTION": _number(curve.friction), "SCALE": _number(curve.friction),
            "SLIP": _number(curve.slip), "LOAD_SCALE": _number(curve.load_scale),
            "REST": _number(curve.rest), "ORIGIN": _number(curve.origin),
            "LEAST": _number(curve.nearest), "NEAREST": _number(curve.origin + curve.nearest),
        }  # fmt: skip
    if order.bank is not None:
        tops, weights = order.bank.tops, order.bank.weights
        words |= {"SLIDERS": len(tops), "TOPS": _numbers(tops), "WEIGHTS": _numbers(weights)}
    return words


def declarations(order: Order) -> str:
    """Return the declarations of the functions that users of the C file call."""
    return _filled("declarations.h", order)


def definitions(order: Order) -> str:
    """Return tables and functions in C; internal names are prefixed with the export's ``name``."""
    memory, kernel = ("sliders.c", "_sliders.h") if order.bank else ("history.c", "_front.h")
    text = _filled(
        memory,
        order,
        CURVE=_curve(order),
        KERNEL=(files("microslip._core.kernels") / kernel).read_text(encoding="utf-8"),
        COMMON=_filled("common.c", order),
    )
    text = text.replace("Py_ssize_t", "int").replace(
        " Part of _compiled.c, and of what is exported as C.", ""
    )
    internal = set(_STATIC.findall(text)) | set(_TYPE.findall(text)) | _CONSTANTS
    return re.sub(rf"\b({'|'.join(sorted(internal))})\b", rf"{order.name}_\1", text)


def _curve(order: Order) -> str:
    if order.element == "planar":
        return ""
    if order.element != "joint":
        curve = order.load_panels
        profile = curve.profile
        return _filled(
            "load_curve.c", order, INVERSE_WIDTH=_number(profile.inverse_width),
            ANCHOR=_number(profile.anchor), FIRST=profile.first,
            **_panels(profile.coefficients, curve.middles),
        )  # fmt: skip
    panels = order.panels
    *middles, end = panels.middles.tolist()
    even = panels.inverse_width > 0.0
    words = {
        "LIMIT": _number(panels.limit), "WHOLE": _number(end),
        "STIFFNESS": _number(float(panels._evaluate(np.zeros(1))[1][0])),
        "OVER": 1 if even else "panel == 0", "EDGES": _numbers(panels.edges),
        "INVERSE_WIDTH": _number(panels.inverse_width),
        "CONTENT": "T0/u" if even else "T0/u on the first one, T0 on the others",
        **_panels(panels.coefficients, np.array(middles)),
    }  # fmt: skip
    table = _filled("even_panels.c" if even else "unequal_panels.c", order, **words)
    return _filled("backbone.c", order, TABLE=table, **words)


def _panels(coefficients: Floats, middles: Floats) -> dict[str, object]:
    rows = ",\n".join(f"    {{{', '.join(map(_number, row))}}}" for row in coefficients)
    return {
        "PANELS": len(coefficients), "TERMS": coefficients.shape[1],
        "COEFFICIENTS": rows, "MIDDLES": _numbers(middles),
    }  # fmt: skip


def _filled(name: str, order: Order, **values: object) -> str:
    return render(name, order.element, **_words(order), **values)


def write_c(order: Order) -> Files:
    """Return the C source, its header and its Fortran interface by file name."""
    header = order.header()
    if order.bank is None:
        memory = [
            f"Up to {order.depth} rows of memory are stored. If more are needed, the oldest loops",
            f"are merged, and {order.name}_error() bounds the error of a motion that returns to",
            "their amplitude. Stiffnesses are those of the table.",
        ]
    else:
        memory = [f"{len(order.bank.tops)} sliders, each with a vector, share the memory."]
    top = comment([*header, "", *memory])
    fortran = comment([*header, "", *memory], "! ", "", "")
    return {
        order.stem + order.suffix: f"{top}\n{declarations(order)}\n{definitions(order)}",
        f"{order.stem}.h": f"{top}\n{declarations(order)}",
        f"{order.stem}.f90": f"{fortran}\n{_filled('interface.f90', order)}",
    }


def write_user(order: Order) -> Files:
    """Return the C file with Abaqus user routines by name."""
    text = comment(order.header()) + "\n".join(
        ("", declarations(order), definitions(order), _filled("abaqus.c", order))
    )
    return {order.stem + order.suffix: text}


def _number(value: float) -> str:
    return repr(float(value))


def _numbers(values: Floats) -> str:
    return ",\n".join(
        "    " + ", ".join(map(_number, values[i : i + 4])) for i in range(0, len(values), 4)
    )
