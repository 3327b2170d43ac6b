"""Floor 9: what a tribometer recorded."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from microslip.cli.frame import echo_json
from microslip.cli.options import offers, spelling
from microslip.cli.records import Reading, reads, writes
from microslip.cli.shell import complete_study
from microslip.cli.work import progress, stoppable
from microslip.tribometer.options import CONFIDENCE, RIG_STIFFNESS

if TYPE_CHECKING:
    from microslip.friction import Interface
    from microslip.tribometer import Record


@click.command(short_help="Measure the loops in a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, required=True, type=click.Path())
@writes("report, table and figure", "measurement")
@reads()
@offers(RIG_STIFFNESS)
@click.option(
    "--model",
    type=click.Path(path_type=Path, readable=False),
    metavar="STUDY",
    shell_complete=complete_study,
    help="Study whose joint tells the regimes apart; without it one sphere does.",
)
@offers(CONFIDENCE)
def measure(
    records: tuple[str, ...],
    folder: Path | None,
    overwrite: bool,
    kinds: tuple[str, ...],
    as_json: bool,
    reading: Reading,
    rig_stiffness: float | None,
    model: Path | None,
    confidence: float,
) -> None:
    """Measure every cycle in each RECORD: CSV, TXT, TSV, MAT, TDMS or HDF5.

    Energy, damping, friction, stiffness and regime, with confidence intervals of their means.
    Columns and units that are not given are found, and shown. The files are only read.
    """
    with stoppable():
        from contextlib import ExitStack

        from microslip.errors import InputError, said
        from microslip.report.folder import staged
        from microslip.report.terminal import show
        from microslip.results.measured import KIND, document, file_names, write
        from microslip.tribometer import measure as measured
        from microslip.tribometer.record import shown_path

        with ExitStack() as stack:
            stage = None
            if folder is not None:  # first, so that nothing is read in vain
                stage = stack.enter_context(staged(folder, overwrite, KIND, "measurement"))
            joints = [] if model is None else _joints(model)
            report = stack.enter_context(progress("Measuring"))
            records_read = []
            for index, path in enumerate(records):
                try:
                    record = reading.read(path)
                    records_read.append(
                        measured(
                            record,
                            model=_at_the_load_of(record, joints),
                            rig_stiffness=rig_stiffness,
                            confidence=confidence,
                        )
                    )
                except InputError as error:
                    if str(error).startswith(shown_path(path)):
                        raise
                    raise error.within(f"{path}: ") from None
                report((index + 1) / len(records))
            context = click.get_current_context()
            result = document(
                records_read,
                lambda text: said(text, spelling(context)),
                files=file_names(kinds) if stage is not None else (),
            )
            if stage is not None:
                write(result, records_read, stage)
    if as_json:
        echo_json(result.data)
        return
    show(result, sys.stdout)
    if folder is not None:
        click.echo(f"{len(result.data['files'])} files in {folder}")


def _joints(study: Path) -> list[Interface]:
    """The joints of a study, one for each of its loads."""
    from microslip.study.build import build_joints
    from microslip.study.description import StudyDescription

    return build_joints(StudyDescription.load(study))


def _at_the_load_of(record: Record, joints: list[Interface]) -> Interface | None:
    """A study's joint under the load of a record; its own load where the record has none."""
    from microslip.errors import Argument, InputError

    if not joints:
        return None
    if record.normal_load is None:
        if len(joints) > 1:
            raise InputError(
                "the study has several normal loads and the record has none; give ",
                Argument("normal_load", "500 N"),
            )
        return joints[0]
    import numpy as np

    return joints[0].at(normal_load=float(np.mean(record.normal_load)))
