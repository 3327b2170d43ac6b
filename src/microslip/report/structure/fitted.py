"""Parameters of a joint fitted to a modal test, in a document and in the summary."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.quantities import count, dimensionless, hertz, json_value
from microslip.report import cells
from microslip.report.document import Section, Table, Verdicts
from microslip.structures import ModalIdentification
from microslip.study.runs.structure_prediction import StructurePrediction


def fitted_numbers(identified: ModalIdentification) -> dict[str, Any]:
    """Return the fitted parameters and curves as plain values in SI units."""
    return {
        "values": dict(identified.values),
        "intervals": {name: list(ends) for name, ends in identified.intervals.items()},
        "scatter": dict(zip(identified.values, identified.scatter.tolist(), strict=True)),
        "correlation": identified.correlation.tolist(),
        "misfit": json_value(identified.misfit),
        "linear_frequencies": [
            dict(zip(("test", "study", "fitted"), row, strict=True))
            for row in identified.linear_frequencies.tolist()
        ],
        "curves": [
            {
                "mode": curve.index + 1,
                "amplitude": json_value(curve.amplitude),
                "modal_frequency": json_value(curve.frequency),
                "modal_damping_ratio": json_value(curve.damping_ratio),
                "modal_frequency_bands": json_value(band[0]),
                "modal_damping_ratio_bands": json_value(band[1]),
            }
            for curve, band in zip(identified.curves, identified.bands, strict=True)
        ],
        "verdicts": [v.word for v in identified.verdicts],
    }


_FITTED = {
    "friction_coefficient": "Friction coefficient",
    "tension": "Bolt tension over that of the study",
    "form": "Factor on the form",
    "young_modulus": "Young's modulus over that of the study",
    "base_damping_ratio": "Base damping ratio",
}


def fitted_section(prediction: StructurePrediction, identified: ModalIdentification) -> Section:
    """Return the section on the fitted parameters and their verdicts."""
    data = DataSet.of_rows(
        {
            name: (dimensionless(_FITTED[name]), (value, *identified.intervals[name]))
            for name, value in identified.values.items()
        }
    )
    table = cells.by_quantity("Fitted to the test", data, ("Parameter", "Value (5 to 95 %)"))
    verdicts = Verdicts(identified.verdicts, caption=_strongest_correlation(identified))
    return Section("Fitted to the test", (table, verdicts, _linear(prediction, identified)))


def _linear(prediction: StructurePrediction, identified: ModalIdentification) -> Table:
    labels = ("Test, smallest amplitude", "Joints stick, as in the study", "Joints stick, fitted")
    columns: dict[str, Any] = {"mode": (count("Mode"), [t.mode + 1 for t in prediction.tests])}
    for label, values in zip(labels, identified.linear_frequencies.T, strict=True):
        columns[label] = hertz(label), values
    return Table("Linear frequencies", DataSet.of_rows(columns), noun="tests")


MOTIONS = {"steady": "steady motion", "decay": "free decay"}


def _strongest_correlation(identified: ModalIdentification) -> str:
    names, matrix = tuple(identified.values), abs(identified.correlation)
    if len(names) < 2:
        return ""
    first, second = divmod(int(np.argmax(np.triu(matrix, 1))), len(names))
    value = identified.correlation[first, second]
    return f"{_FITTED[names[first]]} and {_FITTED[names[second]].lower()} correlate by {value:.2f}."
