"""Backbone, energies and cells as plain numbers."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from microslip.export.request import Accuracy, Order

_POINTS = 200


def write(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """One JSON file, or two CSV files: the curves, and beside them the cells."""
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
