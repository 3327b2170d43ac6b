"""The command ``identify``: the joint behind a tribometer's records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microslip.cli.group import OneOf
from microslip.cli.lists import complete_study
from microslip.cli.options import (
    ANY_PATH,
    FIGURES,
    Output,
    in_options,
    option,
    progress,
    stoppable,
    switch,
    writes,
)
from microslip.cli.records import (
    CYCLES,
    MANIFEST,
    WORN_VOLUMES,
    Listed,
    Reading,
    calibration_of,
    each_of,
    listed,
    options_of,
    reads,
)
from microslip.cli.structures import BAND, has_structure, identify_structure
from microslip.identification.options import LAWS, LOSSES, NUISANCES

if TYPE_CHECKING:
    from microslip.laboratory import Measurement, Record


class FittedLaw(OneOf):
    """A law that can be fitted: the usual ones, or any other that is exported."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name of the law, or an error that lists them."""
        if value not in self.choices:
            from microslip.identification.models import MODELS

            self.choices = tuple(model.name for model in MODELS)
        return super().convert(value, param, ctx)


@click.command(short_help="Identify a joint from a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, type=click.Path())
@option(
    "--law", "LAW",
    f"{', '.join(LAWS)}; by default the first. Repeated, the laws are compared.",
    "laws", multiple=True, type=FittedLaw(LAWS),
)  # fmt: skip
@option(
    "--study", "STUDY",
    "Study with the materials, the kind of heights and the values to start from.",
    type=ANY_PATH, shell_complete=complete_study,
)  # fmt: skip
@writes(
    "Folder for report, tables and figures; without it nothing is written.",
    "identification", *FIGURES,
)  # fmt: skip
@option(
    "--fix", "NAME=VALUE",
    'Fix a parameter, such as slip_scale="0.3 um"; may be repeated.',
    multiple=True,
)  # fmt: skip
@option(
    "--bound", "NAME=LOW..HIGH",
    'Bounds of a parameter, such as slip_scale="0.1..1 um"; may be repeated.',
    multiple=True,
)  # fmt: skip
@option(
    "--rig-stiffness", "VALUE",
    'Rig in series: free, rigid, "2e8 N/m", or with its deviation, "200±5 N/um".',
    default="free", show_default=True,
)  # fmt: skip
@option(
    "--rig", "LABEL",
    "Name of the rig of each record, once for each in their order, where there are several.",
    "rigs", multiple=True,
)  # fmt: skip
@option(
    "--contact-area", "AREA",
    'A measured real contact area, its uncertainty and load: "6 mm^2, 1 mm^2, 2 kN".',
)  # fmt: skip
@option(
    "--known", "NAME=VALUE±SD",
    "A value from elsewhere, such as a scan, with its standard deviation: "
    'radius="1±0.1 mm", density="100±5 1/mm^2", std="0.5±0.02 um"; may be repeated.',
    "known_values", multiple=True,
)  # fmt: skip
@option(
    "--summits", "NUMBER",
    "Number of all summits under the apparent area, to include their sampling scatter in the "
    "intervals; inf for continuous heights.",
    type=float,
)  # fmt: skip
@option(
    "--nuisance", "NAME",
    f"Additional force terms to fit: {', '.join(NUISANCES)}.",
    "nuisances", multiple=True, type=OneOf(NUISANCES),
)  # fmt: skip
@MANIFEST
@WORN_VOLUMES
@CYCLES
@option(
    "--noise", "FORCE,LENGTH",
    'Standard deviations of a force and a displacement, such as "2 N, 5 nm"; each record is then '
    "one averaged cycle.",
)  # fmt: skip
@option(
    "--loss", "LOSS", f"Loss function of the residuals: {', '.join(LOSSES)}.",
    type=OneOf(LOSSES), default=LOSSES[0], show_default=True,
)  # fmt: skip
@click.option(
    "--free-delay", is_flag=True,
    help="Fit a delay between the channels, too.",
)  # fmt: skip
@option(
    "--delay", "TIME",
    'Time by which the force lags behind the displacement, such as "50 us", or free.',
    "lag",
)  # fmt: skip
@option(
    "--held-back", "SHARE", "Share of the cycles to predict, not fit.",
    type=float, default=0.25, show_default=True,
)  # fmt: skip
@click.option(
    "--confidence",
    type=float,
    default=0.95,
    show_default=True,
    help="Confidence level of the intervals.",
)
@switch("--accept-unconverged", "Also show and write a fit that has not converged.")
@BAND
@reads(many_loads=True)
def identify(
    records: tuple[str, ...],
    laws: tuple[str, ...],
    study: Path | None,
    output: Output,
    rigs: tuple[str, ...],
    manifest: Path | None,
    worn_volumes: tuple[str, ...],
    accept_unconverged: bool,
    band: str | None,
    reading: Reading,
    **values: Any,
) -> None:
    """Identify the joint that made each RECORD, several loads and amplitudes at once.

    A folder stands for the records in it; a file that cannot be read is listed and left out.
    Gives values with intervals, what the records cannot determine and what to measure for it,
    residuals and a comparison of laws. With -o a page, figures, tables and, given the materials by
    --study, joint.toml, a study for microslip predict.

    With --study of a bolted structure each RECORD is a test of one of its modes (a ring-down, a
    stepped sine, or a table of amplitude, frequency and damping ratio), and friction, bolt tension
    and a factor on the form are fitted to them.
    """
    from microslip._core.errors import InputError

    if study is not None and has_structure(study):
        identify_structure(study, records, output, band)
        return
    if band is not None:
        raise click.UsageError("--band is for a mode's ring-down, with a structure in --study")
    laws = tuple(dict.fromkeys(laws)) or LAWS[:1]
    if values["free_delay"] and values["lag"] is not None:
        raise click.UsageError("--delay and --free-delay contradict each other; give one of them")
    with stoppable():
        from microslip.report.files import write
        from microslip.report.identified.document import (
            KIND,
            document,
            identified,
            measured_together,
        )

        files = listed(records, manifest, (), worn_volumes)
        records = tuple(files.paths)
        remedy = "; records of one rig need none"
        rigs = rigs or (files.manifest.texts("rig") if files.manifest is not None else ())
        rig_labels = each_of("--rig", rigs, len(records), "a label", remedy)
        _, gain_errors = calibration_of(reading.calibration)
        options = {**options_of(values, laws), "rigs": list(rig_labels) or None}
        options["gain_errors"] = gain_errors or None
        description = None
        if study is not None:
            from microslip.study.description import StudyDescription  # and all of structures

            description = StudyDescription.load(study)
        with output.staged(KIND, "identification") as stage:
            with progress("Reading") as report:
                read, skipped = _read(files, reading, options, report)
            rows = [i for i, path in enumerate(records) if path not in dict(skipped)]
            with progress("Fitting") as report:
                result = identified(read, laws, description, options, report)
                result = replace(result, skipped=tuple(skipped))
                first = result.first
                if not accept_unconverged and not first.converged:
                    raise InputError(
                        f"{first.law}: {first.status}: {first.message} (--accept-unconverged "
                        "shows it all the same)"
                    )

            def known(places: list[int]) -> dict[str, Any]:
                file_rows = [rows[i] for i in places]
                runs = rigs or files.runs
                return {
                    "runs": [runs[i] for i in file_rows] if runs else None,
                    "worn_volumes": [files.volumes[i] for i in file_rows]
                    if files.volumes
                    else None,
                    "columns": files.columns(file_rows),
                }

            def counted(measured: Measurement, place: int) -> Measurement:
                read_from = files.manifest
                return measured if read_from is None else read_from.counted(measured, rows[place])

            campaign = measured_together(
                read, options["confidence"], options["cycles"], counted, result.first, known
            )
            page = document(replace(result, campaign=campaign), in_options, files=stage is not None)
            if stage is not None:
                with progress("Drawing and writing") as report:
                    page = write(page, stage, output.kinds, report)
    output.tell(page)


def _read(
    files: Listed, reading: Reading, options: dict[str, Any], report: Any
) -> tuple[list[Record], list[tuple[str, str]]]:
    """The records, and the files that are none, if there are others."""
    from microslip._core.errors import InputError

    paths, loads = files.paths, reading.normal_load
    if len(loads) != 1:  # which stands for all
        each_of("--normal-load", loads, len(paths), "one for all records or one")
    loaded: list[Record] = []
    skipped: list[tuple[str, str]] = []
    rigs = options["rigs"]
    for index, path in enumerate(paths):
        try:
            record = reading.read(path, index)
            loaded.append(
                record if files.manifest is None else files.manifest.loaded(record, index)
            )
        except InputError as error:
            if len(paths) == 1 or (index == len(paths) - 1 and not loaded):
                raise
            why = in_options(error.text)
            skipped.append((path, why.removeprefix(f"{path}: ")))
            if rigs is not None:
                rigs[index] = None
        report((index + 1) / len(paths))
    if rigs is not None:
        options["rigs"] = [label for label in rigs if label is not None]
    return loaded, skipped
