"""Many studies, records or scans in one command, and inverse design."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import click

from microslip.cli.group import echo_json
from microslip.cli.options import ANY_PATH, JSON, Output, option, output_option, switch, writes
from microslip.cli.shell import complete_study
from microslip.cli.studies import overridable, study_argument
from microslip.cli.work import progress, stoppable


def _shard(context: click.Context, param: click.Parameter, value: str | None) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)/(\d+)", value or "1/1")
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise click.UsageError(f"--shard: wanted I/N such as 3/10, got {value}", context)
    return int(match[1]), int(match[2])


@click.command(short_help="Run many studies, records or scans; restartable.")
@click.argument("source", metavar="FOLDER|LIST", type=ANY_PATH)
@option(
    "--study", "STUDY",
    "Study of a table or of scans; for records the joint that defines the regimes.",
    type=ANY_PATH, shell_complete=complete_study,
)  # fmt: skip
@output_option("Folder of the results; by default SOURCE-batch in the current folder.")
@click.option(
    "--workers", type=click.IntRange(1, 256), default=1, show_default=True, help="Processes."
)
@option(
    "--dask", "ADDRESS",
    'Address of a Dask scheduler, or "local" for a cluster of --workers here.',
    answers_for=("dask",),
)  # fmt: skip
@option("--shard", "I/N", "Run only part I of N, as in a Slurm job array.", callback=_shard)
@JSON
def batch(
    source: Path,
    study: Path | None,
    folder: Path | None,
    workers: int,
    dask: str | None,
    shard: tuple[int, int],
    as_json: bool,
) -> None:
    """Run all items of a FOLDER or a LIST: studies, records, scans, or changes to a study.

    A LIST is a text file with a path in each line, or a CSV table whose columns are keys of the
    study. Outcomes are saved one by one: after a stop the same command continues. Failures are
    listed with their reason and tried again by the next run.
    """
    with stoppable():
        from microslip.report.terminal import show
        from microslip.results.batched import document, finish
        from microslip.runs.batch import earlier_outcomes, items_of, prepare, run

        items = items_of(source, study)
        folder = folder or Path(f"{source.stem}-batch")
        prepare(folder)
        with progress("Running") as report:
            part = items[shard[0] - 1 :: shard[1]]
            outcomes = run(part, folder, workers, dask, report)
        total = outcomes.of_all(items, earlier_outcomes(folder, items, failures=True))
        finish(total, folder)
        result = document(total)
    if as_json:
        echo_json(result.data)
        return
    show(result, sys.stdout)
    click.echo(f"Results in {folder}")


@click.command(short_help="Find the load, area or roughness that meets a target.")
@study_argument
@option(
    "--target", "TEXT", 'Target, such as "damping_ratio >= 0.5 % at 10 um", or of a '
    'structure "mode 1 frequency >= 180 Hz at 1 um".',
    required=True, answers_for=("target",),
)  # fmt: skip
@option(
    "--vary", "KEY=LOW..HIGH",
    'Key to change and its range, such as "joint.normal_load=500 N..5 kN"; may be repeated.',
    "ranges", required=True, multiple=True, answers_for=("vary",),
)  # fmt: skip
@click.option(
    "--probability", type=float, default=0.9, show_default=True,
    help="Probability of meeting the target, where numbers of the study are uncertain.",
)  # fmt: skip
@switch("--no-trade-off", "Leave out the designs for other levels of the target.")
@writes(
    "Folder for report and figures; without it only the table is printed.", "result", overridable
)
def design(
    study: Path,
    target: str,
    ranges: tuple[str, ...],
    probability: float,
    no_trade_off: bool,
    output: Output,
    overrides: tuple[str, ...],
) -> None:
    """Find the smallest change of STUDY that meets a target, and plot the trade-off."""
    with stoppable():
        from microslip.report.files import listed, save, standard_files
        from microslip.results.designed import KIND, document
        from microslip.runs.design import Target
        from microslip.runs.modal_design import open_search
        from microslip.study.description import StudyDescription

        goal = Target.read(target)
        with progress("Searching") as report:
            search = open_search(StudyDescription.load(study, overrides), goal, ranges, probability)
            solution = search.solve(progress=report)
        with progress("Trading off") as report:
            curve = [] if no_trade_off else search.trade_off(report)
        result = document(search, solution, curve)
        if output.folder is not None:
            result = listed(result)
            save(standard_files(result), output.folder, KIND, "result", output.overwrite)
    output.tell(result)
