"""Tables of a law as JSON or CSV (backbone, energies, Jenkins cells), and files of fitted laws."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from microslip.export.request import Accuracy, Order
from microslip.friction import BackboneLaw
from microslip.friction.law_files import law_content, law_text

_POINTS = 200


def write_table(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """Return one JSON file, or two CSV files: curves of the law, and Jenkins cells fitted to it."""
    law = order.law
    a = np.geomspace(*order.span, _POINTS)
    curves = {
        "displacement [m]": a,
        "force [N]": law._backbone(a),
        "stiffness [N/m]": law._slope(a),
        "dissipated energy of a cycle of this amplitude [J]": law._energy(a),
    }
    (model,) = order.cell_models
    cells = {
        "stiffness [N/m]": np.asarray(model.stiffnesses),
        "force limit [N]": np.asarray(model.force_limits),
    }
    fit = model.fit
    of_cells = Accuracy(*order.span, fit.backbone_error, fit.energy_error)
    exact = Accuracy(*order.span, 0.0, 0.0)
    if order.suffix == ".json":
        content: dict[str, Any] = {
            "header": order.header(exact),
            "force_limit": law.force_limit,
            "tangential_stiffness": law.tangential_stiffness,
            "curves": {name: values.tolist() for name, values in curves.items()},
            "cells": {name: values.tolist() for name, values in cells.items()},
            "accuracy_of_cells": asdict(of_cells),
        }
        return {f"{order.stem}.json": json.dumps(content, indent=1) + "\n"}, exact
    return {
        f"{order.stem}.csv": _csv(order.header(exact), curves),
        f"{order.stem}-cells.csv": _csv(order.header(of_cells), cells),
    }, exact


def _csv(header: list[str], columns: dict[str, Any]) -> str:
    lines = [*(f"# {line}" for line in header), ",".join(columns)]
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([*lines, *(",".join(map(repr, row)) for row in rows)]) + "\n"


def write_fitted(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """Return the files of the Segalman or Iwan model fitted to the exported law, and its errors."""
    low, high = order.span
    model: BackboneLaw
    if order.kind == "segalman":
        fit = order.law.to_segalman(low, high)
        model = fit.law
        misfit = {
            "rms_log_energy": fit.misfit,
            "largest_log_energy": fit.largest_misfit,
            "force_over_limit": fit.force_misfit,
        }
        accuracy = Accuracy.of(order.law, order.span, model._backbone, model._energy)
    else:
        (cells,) = order.cell_models
        model = cells
        misfit = {"backbone": cells.fit.backbone_error, "energy": cells.fit.energy_error}
        accuracy = Accuracy(*order.span, cells.fit.backbone_error, cells.fit.energy_error)
    content = law_content(model) | {"header": order.header(accuracy), "misfit": misfit}
    law_file = f"{order.stem}.json"
    files: dict[str, str | bytes] = {law_file: law_text(content)}
    if order.suffix == ".toml":
        lines = [f"# {line}" for line in order.header(accuracy)]
        lines += [
            f"# Misfit, {key.replace('_', ' ')}: {value:.3g}" for key, value in misfit.items()
        ]
        lines += ["", "schema = 1", "", "[joint]", f"law_file = {json.dumps(law_file)}"]
        lines += ["", "[excitation]", f'amplitudes = ["{low!r} m", "{high!r} m"]']
        files = {f"{order.stem}.toml": "\n".join(lines) + "\n", **files}
    return files, accuracy
