"""Floor 12: the joint of a bolted structure, from a test of one of its modes."""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import click

from microslip.cli.frame import echo_json
from microslip.cli.studies import predict_into
from microslip.cli.work import progress, stoppable


def has_structure(study: Path) -> bool:
    """Whether a study describes a bolted structure; what cannot be read is told elsewhere."""
    try:
        return "structure" in tomllib.loads(study.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


def identify_structure(
    study: Path, records: Sequence[str], folder: Path | None, overwrite: bool, as_json: bool
) -> None:
    """Predict the structure with a fit to its test."""
    from microslip.results import Study

    if len(records) != 1:
        raise click.UsageError(
            "a structure is identified from one table of amplitude, frequency and damping ratio, "
            f"got {len(records)}"
        )
    given = tomllib.loads(study.read_text(encoding="utf-8"))["structure"]
    file = json.dumps(str(Path(records[0]).resolve()))
    overrides = [f"structure.measured.file={file}"]
    if "fit" not in given.get("measured", {}):
        fit = ["friction_coefficient", "tension", *(["form"] if "form" in given else [])]
        overrides.append(f"structure.measured.fit={json.dumps(fit)}")

    def read() -> Study:
        return Study.load(study, overrides)

    if folder is not None:
        predict_into(read, folder, overwrite, as_json)
        return
    with stoppable():
        from microslip.report.terminal import show
        from microslip.results.predicted.document import document

        loaded = read()
        with progress("Fitting") as report:
            result = loaded.run(report)
        if as_json:
            echo_json(result.summary["structure"]["identified"])
        else:
            show(document(result), sys.stdout)
