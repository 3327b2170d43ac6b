"""Floor 8: what was given beside the records, and what hangs on the law, as people read it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from microslip._core.units import significant
from microslip.identification.verdicts import shown_interval
from microslip.study.identified_tables import Table, label, quantity


def given_table(found: Mapping[str, Any]) -> Table | None:
    """What was given with an uncertainty beside what was found; None where nothing was.

    Parameters
    ----------
    found : mapping
        An identification, as summary.json has it.

    Returns
    -------
    Table or None
        A row a datum.
    """
    rows = [
        [
            label(one["name"]),
            " ± ".join(quantity(one[key], one["unit"]) for key in ("value", "uncertainty")),
            quantity(one["found"], one["unit"]),
            _signed(one["residual"]),
            significant(abs(one["disagreement"]), 2),
            "agrees" if one["agrees"] else "disagrees",
        ]
        for one in found["given"]
    ]
    head = ["what was given", "value", "found", "deviations off", "from the rest", "verdict"]
    return Table(head, rows) if rows else None


def _signed(value: float | None) -> str:
    return "–" if value is None else f"{value:+.2f}".replace("-", "−")


def hanging_of(found: Mapping[str, Any]) -> list[str]:
    """What is to be said of numbers that are identified, but only under the law.

    Parameters
    ----------
    found : mapping
        An identification, as summary.json has it.

    Returns
    -------
    list of str
        A sentence a number.
    """
    return [
        f"{text[:1].upper()}{text[1:]}: {number['reason']}. To settle it: {number['remedy']}."
        for name, number in found["parameters"].items()
        if number["verdict"] == "identified" and number["reason"]
        for text in (label(name, number.get("normal_load")),)
    ]


def rig_texts(comparison: Mapping[str, Any]) -> list[str]:
    """The stiffness of each rig as several laws find it.

    Parameters
    ----------
    comparison : mapping
        The laws side by side, as summary.json has them.

    Returns
    -------
    list of str
        A sentence for each rig that several laws have; none where it is known.
    """
    texts = []
    for name, laws in comparison["rigs"].items():
        each = ", ".join(f"{_between(one)} by {law}" for law, one in laws.items())
        texts.append(
            f"The {label(name)} over the laws: {each}. Where all of them leave more than noise, it "
            "takes up what each law lacks, and this spread says more of it than one interval."
        )
    return texts


def _between(one: Mapping[str, Any]) -> str:
    low, high = (quantity(one[end], one["unit"], 3) for end in ("low", "high"))
    return shown_interval((low, high), one["low_open"], one["high_open"])
