"""The command ``identify``: identify a joint from tribometer records."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from microslip.cli.options import (
    ANY_PATH,
    Output,
    click_option,
    in_options,
    progress,
    stoppable,
    writes,
)
from microslip.cli.records import (
    MANIFEST_OPTION,
    Reading,
    calibration_of,
    each_record,
    list_records,
    parse_noise,
    reads,
    rig_stiffness_of,
)
from microslip.cli.structures import are_modal


@click.command(short_help="Identify a joint from a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, type=click.Path())
@click_option(
    "--study", "STUDY",
    "Study with materials, area and height distribution, to identify the parameters of the "
    "interface.",
    type=ANY_PATH,
)  # fmt: skip
@writes(
    "Folder for report, tables, figures, law.json and joint.toml; without it nothing is written.",
    "identification",
)  # fmt: skip
@click_option(
    "--rig-stiffness", "VALUE±SD",
    'Measured stiffness of the rig in series with its standard deviation, such as "200±5 N/um"; '
    "without it, results are for joint and rig in series.",
)  # fmt: skip
@click_option(
    "--noise", "FORCE,LENGTH",
    'Standard deviations of force and displacement, such as "2 N, 5 nm", for records that are one '
    "averaged cycle each.",
)  # fmt: skip
@MANIFEST_OPTION
@reads
def identify(
    records: tuple[str, ...],
    study: Path | None,
    output: Output,
    rig_stiffness: str | None,
    noise: str | None,
    manifest: Path | None,
    reading: Reading,
) -> None:
    """Identify a joint from RECORDs, which may differ in load and amplitude.

    Reports force, energy and damping against amplitude with their intervals, the stiffness at rest
    and the force limit. A RECORD may be a folder of records; files that cannot be read are listed
    and skipped. --study adds the parameters of the interface. -o writes a report, figures, tables,
    law.json and joint.toml, a study for microslip predict with the same intervals.

    Tests of the modes of a bolted structure are fitted by microslip predict, with the key
    structure.measured of its study.
    """
    if manifest is None and reading.force is None and are_modal(records):
        raise click.UsageError(
            f"{records[0]} is a test of a mode: name it in the study of the structure, as file in "
            "[structure.measured] with fit = [...], and run microslip predict"
        )
    with stoppable():
        from microslip.identification import identify
        from microslip.report.files import write_document
        from microslip.report.identified import Identified, identification_document

        files = list_records(records, manifest)
        _, gain_errors = calibration_of(reading.calibration)
        gains = {f"{name}_gain": (1.0, error) for name, error in gain_errors.items()}
        with output.staged("identification") as stage:
            with progress("Reading") as report:
                read, _, skipped = each_record(files, reading, lambda record: record, report)
            with progress("Fitting") as report:
                found = identify(
                    read,
                    rig_stiffness=rig_stiffness_of(rig_stiffness),
                    noise=parse_noise(noise),
                    known=gains or None,
                )
                report(0.7)
                step, title, why = _second_step(found, study)
                report(1.0)
            outcome = Identified(found, title, step, why, tuple(skipped))
            page = identification_document(outcome, in_options)
            if stage is not None:
                with progress("Drawing and writing") as report:
                    page = write_document(page, stage, output.kinds, report)
    output.show(page)


def _second_step(found: Any, study: Path | None) -> tuple[Any, str, str]:
    """Fit the parameters of a study's rough surfaces to the identified joint.

    Return the interface, the title of the study and, if the interface is None, the reason.
    """
    from microslip._core.errors import InputError

    if study is None:
        return (
            None,
            "",
            "To identify parameters of the interface, give its materials with --study STUDY.toml",
        )
    from microslip.contact import GreenwoodWilliamson
    from microslip.study.build import build_surface
    from microslip.study.description import StudyDescription

    description = StudyDescription.load(study)
    surface = build_surface(description) if description.surface is not None else None
    if not isinstance(surface, GreenwoodWilliamson):
        why = (
            f"The surface of {study.name} has no height distribution, which the parameters of the "
            "interface require."
        )
        return None, description.title, why
    try:
        step = found.interface(surface.pair, area=surface.area, heights=surface.heights)
    except InputError as error:
        return None, description.title, f"No parameters of the interface: {in_options(error.text)}"
    return step, description.title, ""
