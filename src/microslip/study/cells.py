"""Floor 8: how numbers of a result stand in tables, on the terminal and in the report alike."""

from __future__ import annotations

from typing import Any

from microslip._core.units import significant

COUNTING_LAWS = ("population", "sphere")
"""Normal laws whose contacts are counted, one by one."""

IN_PERCENT = "real over apparent area"
"""The one verdict that stands in percent, as in the tables."""


def ratio(value: float | None) -> str:
    """Write a ratio; decimals below each other where they all show something."""
    return f"{value:.3f}" if value is not None and value >= 0.0995 else significant(value)


def force_ratio(value: float) -> str:
    """Write a ratio that tends to one, where all slides, and says so only once it is there."""
    return ">0.999" if 0.9995 <= value < 1.0 - 1e-12 else ratio(value)


def contact_count(count: float | None, law: str) -> str:
    """Write how many contacts: whole where they are counted, else digits of the expected number."""
    if count is None:
        return "–"
    return f"{count:.0f}" if law in COUNTING_LAWS or count >= 100.0 else significant(count)


def standardised(h: float | None) -> str:
    """Write a separation over the spread of the heights."""
    return "–" if h is None else f"{h:.3f}" if abs(h) < 1000.0 else f"{h:.3g}"


def verdict_value(name: str, value: float) -> str:
    """Write what is judged."""
    return f"{significant(100.0 * value)} %" if name == IN_PERCENT else significant(value)


def verdict_limit(name: str, limit: float) -> str:
    """Write what it is held to, a number that somebody chose."""
    return f"{100.0 * limit:.3g} %" if name == IN_PERCENT else f"{limit:.3g}"


def is_by_force(summary: dict[str, Any]) -> bool:
    """Whether force amplitudes were prescribed."""
    return summary["study"]["excitation"].get("force_amplitudes") is not None


def pictures(names: list[str]) -> tuple[list[str], list[str]]:
    """Figures among the names of files, each once, and the endings that they come with."""
    split = [name.rpartition(".") for name in names if name.endswith((".svg", ".png"))]
    stems = dict.fromkeys(stem for stem, _, _ in split)
    return list(stems), list(dict.fromkeys(f".{kind}" for _, _, kind in split))
