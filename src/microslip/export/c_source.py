"""One C99 file of a law, exact, with its header and its interface for Fortran."""

from __future__ import annotations

from importlib.resources import files

from microslip._core.checks import Floats
from microslip.export.request import Accuracy, Order

_FOLDER = files("microslip.export") / "templates"


def filled(name: str, **values: object) -> str:
    """A template with its words between @ in place."""
    text = (_FOLDER / f"{name}.template").read_text(encoding="utf-8")
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


def comment(lines: list[str], start: str = " * ", first: str = "/*\n", last: str = " */\n") -> str:
    """Lines as a comment, of C unless it is said otherwise."""
    safe = [line.replace("*/", "* /") for line in lines]
    return first + "".join(f"{start}{line}".rstrip() + "\n" for line in safe) + last


def declarations(order: Order) -> str:
    """What a user of the C file includes."""
    return filled("declarations.h", NAME=order.name, DEPTH=order.depth)


def definitions(order: Order) -> str:
    """Table and functions."""
    panels = order.panels
    values = {
        "NAME": order.name,
        "PANELS": len(panels.coefficients),
        "TERMS": panels.coefficients.shape[1],
        "LIMIT": _number(panels.limit),
    }
    if panels.inverse_width > 0.0:
        table = filled("even_panels.c", INVERSE_WIDTH=_number(panels.inverse_width), **values)
        content = "T0/u"
    else:
        table = filled("unequal_panels.c", EDGES=_numbers(panels.edges), **values)
        content = "T0/u on the first one, T0 on the others"
    rows = ",\n".join(f"    {{{', '.join(map(_number, row))}}}" for row in panels.coefficients)
    return filled("history.c", TABLE=table, CONTENT=content, COEFFICIENTS=rows, **values)


def write(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """Texts by the names of their files."""
    header = order.header()
    memory = [
        f"Up to {order.depth} open reversals are remembered. Where there are more, the oldest",
        f"loops are lumped together, and {order.name}_error() bounds what that costs a motion",
        "that comes back out to them. Stiffnesses are those of the table.",
    ]
    top = comment([*header, "", *memory])
    fortran = comment([*header, "", *memory], "! ", "", "")
    return {
        order.stem + order.suffix: f"{top}\n{declarations(order)}\n{definitions(order)}",
        f"{order.stem}.h": f"{top}\n{declarations(order)}",
        f"{order.stem}.f90": f"{fortran}\n"
        + filled("interface.f90", NAME=order.name, DEPTH=order.depth),
    }, order.accuracy


def _number(value: float) -> str:
    return repr(float(value))


def _numbers(values: Floats) -> str:
    return ",\n".join(
        "    " + ", ".join(map(_number, values[i : i + 4])) for i in range(0, len(values), 4)
    )
