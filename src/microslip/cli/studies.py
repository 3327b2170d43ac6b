"""Commands on studies: predict, demo, check, new and batch."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from microslip.cli.group import OneOf, echo_json
from microslip.cli.options import (
    ANY_PATH,
    JSON,
    Decorator,
    Output,
    click_option,
    output_option,
    progress,
    stoppable,
    switch,
    writes,
)
from microslip.study.new import TEMPLATES, command_line, demo_text, write_template
from microslip.surfaces.options import PROCESS_NAMES

if TYPE_CHECKING:
    from microslip.report import Study


study_argument = click.argument("study", type=ANY_PATH)
overridable = click_option(
    "--set", "KEY=VALUE",
    'Override a key of the study, such as joint.normal_load="3 kN"; may be repeated.',
    "overrides", multiple=True,
)  # fmt: skip


def _writes_into(default: str, *options: Decorator) -> Decorator:
    words = f"Folder for the result; by default {default} in the current folder."
    return writes(words, "result", *options)


@click.command(short_help="Predict loops, energy and damping of a joint.")
@study_argument
@_writes_into("STUDY-result", overridable)
def predict(study: Path, output: Output, overrides: tuple[str, ...]) -> None:
    """Predict loops, energy and damping of the joint described in STUDY, a TOML file.

    Prints tables and writes a folder with a report, data files and figures. A failed run writes no
    folder.
    """

    def read() -> Study:
        from microslip.report import Study

        return Study.load(study, overrides)

    predict_into(read, output.folder or Path(f"{study.stem}-result"), output)


@click.command(short_help="Predict an example joint.")
@switch("--beam", "A bolted beam: damping of its modes, with uncertainty bands.")
@_writes_into("microslip-demo")
def demo(beam: bool, output: Output) -> None:
    """Predict an example: a milled aluminium joint, or a bolted beam.

    The result folder includes the study, which you can copy and change for your own joint.
    """

    def read() -> Study:
        from microslip.report import Study

        name = "demo_beam.toml" if beam else "demo.toml"
        return Study.from_toml(demo_text(beam), name)

    predict_into(read, output.folder or Path("microslip-demo"), output)


def predict_into(read: Callable[[], Study], folder: Path, output: Output) -> None:
    """Run a study, write the output folder and print its tables."""
    output = output._replace(folder=folder)
    with stoppable():
        study = read()
        with output.staged("result") as stage:
            from microslip.report.files import write_all
            from microslip.report.predicted.result import result_document

            with progress("Computing") as report:
                document = result_document(study.run(report), folder)
            assert stage is not None
            with progress("Drawing and writing") as report:
                write_all(document.files, stage, report)
    output.show(document)


@click.command(short_help="Check a study without running it.")
@study_argument
@overridable
@switch("--json", "Print the result as JSON, no tables.", "as_json")
def check(study: Path, overrides: tuple[str, ...], as_json: bool) -> None:
    """Check STUDY: quantities in SI units, the joint at rest, validity. Writes no files.

    Exit code 0 means that predict will run; violated assumptions are reported, but are not errors.
    """
    with stoppable(), progress("Checking") as report:
        from microslip.report.predicted.preview import next_step, preview
        from microslip.study.build import check_draws
        from microslip.study.description import StudyDescription

        description = StudyDescription.load(study, overrides)
        look = preview(description, report)
        step = next_step(look)
        check_draws(description)
    if as_json:
        echo_json(look.data)
    else:
        from microslip.report.terminal import print_document, show_command

        words = [word for override in overrides for word in ("--set", override)]
        print_document(look, sys.stdout)
        command = command_line("microslip", "predict", study, *words)
        show_command(step, command, sys.stdout)


def _list_templates(context: click.Context, param: click.Parameter, value: bool) -> None:
    if value:
        for name, meaning in TEMPLATES.items():
            click.echo(f"{name:<10} {meaning}")
        from microslip.contact.finish import PROCESSES

        click.echo("Processes for --process, with their usual Ra:")
        for name, process in PROCESSES.items():
            low, high = 1e6 * process.low, 1e6 * process.high
            click.echo(f"{name:<10} {low:g} to {high:g} um ({process.source})")
        context.exit()


@click.command(short_help="Write a study to start from.")
@click.argument("name", metavar="NAME.toml", type=ANY_PATH)
@click.option(
    "--template", "kind", type=OneOf(tuple(TEMPLATES)), default="joint", show_default=True,
    help="Kind of study.",
)  # fmt: skip
@click.option(
    "--list", is_flag=True, is_eager=True, expose_value=False, callback=_list_templates,
    help="List the templates, and the Ra by process.",
)  # fmt: skip
@click.option(
    "--process", type=OneOf(PROCESS_NAMES),
    help="Machining process of the faces: bolted plates with its usual Ra.",
)  # fmt: skip
def new(name: Path, kind: str, process: str | None) -> None:
    """Write a commented study NAME.toml, to change in any editor.

    Existing files are never changed.
    """
    if process is not None and kind != "joint":
        raise click.UsageError("--process cannot be combined with --template")
    steps = write_template(name, kind, process)
    click.echo(f"Written to {command_line(name)}. Next:")
    for step in steps:
        click.echo(f"  {step}")


@click.command(short_help="Predict many studies; restartable.")
@click.argument("source", metavar="FOLDER|TABLE", type=ANY_PATH)
@click_option(
    "--study", "STUDY",
    "Study that the rows of a TABLE change.",
    type=ANY_PATH,
)  # fmt: skip
@output_option("Folder of the results; by default SOURCE-batch in the current folder.")
@click.option(
    "--workers", type=click.IntRange(1, 256), default=1, show_default=True, help="Worker processes."
)
@click_option(
    "--dask", "ADDRESS",
    "Address of a Dask scheduler that runs the items, instead of --workers.",
)  # fmt: skip
@JSON
def batch(
    source: Path,
    study: Path | None,
    folder: Path | None,
    workers: int,
    dask: str | None,
    as_json: bool,
) -> None:
    """Predict all studies of a FOLDER, or a study with the changes in each row of a TABLE.

    A TABLE is a CSV file whose columns are keys of the study. Results are saved item by item: after
    an interruption the same command continues. Failed items are listed with the reason and retried
    by the next run.
    """
    with stoppable():
        from microslip.report.batched import finish
        from microslip.report.terminal import print_document
        from microslip.study.runs.batch import items_of, run_batch

        items = items_of(source, study)
        folder = folder or Path(f"{source.resolve().stem}-batch")
        with progress("Running") as report:
            outcomes = run_batch(items, folder, workers, dask, report)
        result = finish(outcomes, folder)
    if as_json:
        echo_json(result.data)
        return
    print_document(result, sys.stdout)
    click.echo(f"Results in {folder}")
