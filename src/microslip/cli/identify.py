"""The command ``identify``: the joint behind a tribometer's records."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microslip.cli.lists import complete_study
from microslip.cli.options import (
    ANY_PATH,
    Output,
    in_options,
    option,
    progress,
    stoppable,
    writes,
)
from microslip.cli.records import (
    MANIFEST,
    Listed,
    Reading,
    calibration_of,
    each_of,
    known_of,
    listed,
    noise_of,
    reads,
    rig_stiffness_of,
)
from microslip.cli.structures import BAND, has_structure, identify_structure

if TYPE_CHECKING:
    from microslip.laboratory import Record


@click.command(short_help="Identify a joint from a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, type=click.Path())
@option(
    "--study", "STUDY",
    "Study with the materials, the area and the kind of heights, for the parameters of the "
    "interface.",
    type=ANY_PATH, shell_complete=complete_study,
)  # fmt: skip
@writes(
    "Folder for report, tables, figures, law.json and joint.toml; without it nothing is written.",
    "identification",
)  # fmt: skip
@option(
    "--rig-stiffness", "VALUE±SD",
    'Measured stiffness of the rig in series with its standard deviation, such as "200±5 N/um"; '
    "without it results are those of joint and rig in series.",
)  # fmt: skip
@option(
    "--known", "NAME=VALUE±SD",
    "A value from elsewhere, such as a scan, with its standard deviation: "
    'radius="1±0.1 mm", density="100±5 1/mm^2", std="0.5±0.02 um"; may be repeated.',
    "known_values", multiple=True,
)  # fmt: skip
@option(
    "--noise", "FORCE,LENGTH",
    'Standard deviations of a force and a displacement, such as "2 N, 5 nm"; each record is then '
    "one averaged cycle.",
)  # fmt: skip
@MANIFEST
@BAND
@reads(
    "displacement", "force", "normal_load", "time", "sample_rate", "flip_sign", "units",
    "calibration", "rows",
    many_loads=True,
)  # fmt: skip
def identify(
    records: tuple[str, ...],
    study: Path | None,
    output: Output,
    rig_stiffness: str | None,
    known_values: tuple[str, ...],
    noise: str | None,
    manifest: Path | None,
    band: str | None,
    reading: Reading,
) -> None:
    """Identify the joint that made each RECORD, several loads and amplitudes at once.

    Gives force, energy and damping against amplitude with their intervals, the stiffness at rest
    and the force limit. A folder stands for the records in it; a file that cannot be read is
    listed and left out. With --study the parameters of the interface follow. With -o a page,
    figures, tables, law.json and joint.toml, a study for microslip predict with the same intervals.

    With --study of a bolted structure each RECORD is a test of one of its modes (a ring-down, a
    stepped sine, or a table of amplitude, frequency and damping ratio), and friction, bolt tension
    and a factor on the form are fitted to them.
    """
    if study is not None and has_structure(study):
        identify_structure(study, records, output, band)
        return
    if band is not None:
        raise click.UsageError("--band is for a mode's ring-down, with a structure in --study")
    with stoppable():
        from microslip.identification import identify
        from microslip.report.files import write_document
        from microslip.report.identified.document import KIND, Identified, document

        files = listed(records, manifest)
        known = known_of(known_values)
        _, gain_errors = calibration_of(reading.calibration)
        gains = {f"{name}_gain": (1.0, error) for name, error in gain_errors.items()}
        with output.staged(KIND, "identification") as stage:
            with progress("Reading") as report:
                read, skipped = _read(files, reading, report)
            with progress("Fitting") as report:
                found = identify(
                    read,
                    rig_stiffness=rig_stiffness_of(rig_stiffness),
                    noise=noise_of(noise),
                    known=gains or None,
                )
                report(0.7)
                step, title, why = _second_step(found, study, known)
                report(1.0)
            page = document(Identified(found, title, step, why, tuple(skipped)), in_options)
            if stage is not None:
                with progress("Drawing and writing") as report:
                    page = write_document(page, stage, output.kinds, report)
    output.tell(page)


def _second_step(
    found: Any, study: Path | None, known: dict[str, tuple[float, float]]
) -> tuple[Any, str, str]:
    """Return the interface of a study, the title of the study, and why there is no interface."""
    from microslip._core.errors import InputError

    if study is None:
        if known:
            raise click.UsageError("--known is for the interface of a study; give --study")
        return None, "", ("The parameters of the interface need its materials: --study STUDY.toml")
    from microslip.contact import GreenwoodWilliamson
    from microslip.study.build import build_as_made
    from microslip.study.description import StudyDescription

    description = StudyDescription.load(study)
    joint, _ = build_as_made(description)
    surface = joint.surface
    if not isinstance(surface, GreenwoodWilliamson):
        return (
            None,
            description.title,
            (
                f"The surface of {study.name} has no distribution of heights, so that no "
                "parameters of an interface follow."
            ),
        )
    try:
        step = found.interface(
            surface.pair, area=surface.area, heights=surface.heights, known=known or None
        )
    except InputError as error:
        return None, description.title, f"No parameters of the interface: {in_options(error.text)}"
    return step, description.title, ""


def _read(
    files: Listed, reading: Reading, report: Any
) -> tuple[list[Record], list[tuple[str, str]]]:
    """Return the records, and the files that are none, if there are others."""
    from microslip._core.errors import InputError

    paths, loads = files.paths, reading.normal_load
    if len(loads) != 1:  # which stands for all
        each_of("--normal-load", loads, len(paths), "one for all records or one")
    loaded: list[Record] = []
    skipped: list[tuple[str, str]] = []
    for index, path in enumerate(paths):
        try:
            loaded.append(reading.read(path, index, files.manifest))
        except InputError as error:
            if len(paths) == 1 or (index == len(paths) - 1 and not loaded):
                raise
            skipped.append((path, in_options(error.text).removeprefix(f"{path}: ")))
        report((index + 1) / len(paths))
    return loaded, skipped
