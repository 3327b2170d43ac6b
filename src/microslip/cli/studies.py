"""The commands that work on a study, and on many."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from microslip.cli.group import OneOf, echo_json
from microslip.cli.lists import complete_key, complete_study
from microslip.cli.options import (
    ANY_PATH,
    FIGURES,
    JSON,
    Decorator,
    Output,
    option,
    output_option,
    progress,
    stoppable,
    switch,
    writes,
)
from microslip.study.new import TEMPLATE_LAWS, TEMPLATES, command_line, demo_text, write_template
from microslip.surfaces.options import PROCESSES

if TYPE_CHECKING:
    from microslip.report import Study


study_argument = click.argument("study", type=ANY_PATH, shell_complete=complete_study)
overridable = option(
    "--set", "KEY=VALUE",
    'Another value for a key of the study, such as joint.normal_load="3 kN"; may be repeated.',
    "overrides", multiple=True, shell_complete=complete_key,
)  # fmt: skip


def _writes_into(default: str, *options: Decorator) -> Decorator:
    words = f"Folder for the result; by default {default} in the current folder."
    return writes(words, "result", *options)


def _with_figures(load: Callable[[tuple[str, ...]], Study], overrides: tuple[str, ...],
                  kinds: tuple[str, ...]) -> Study:  # fmt: skip
    """A study that writes its figures in these formats, too."""
    study = load(overrides)
    formats = study.output.formats
    asked = [kind for kind in kinds if kind != "svg" and kind not in formats]
    if not asked:
        return study
    listed = ", ".join(f'"{kind}"' for kind in (*formats, *asked))
    return load((*overrides, f"output.formats=[{listed}]"))


@click.command(short_help="Predict loops, energy and damping of a joint.")
@study_argument
@click.option(
    "--workers",
    type=click.IntRange(1, 256),
    default=1,
    show_default=True,
    help="Worker processes for the samples of uncertain inputs; results do not depend on it.",
)
@_writes_into("STUDY-result", overridable, *FIGURES)
def predict(study: Path, workers: int, output: Output, overrides: tuple[str, ...]) -> None:
    """Predict loops, energy and damping of the joint that STUDY (a TOML file) describes.

    Prints tables and writes a folder with a report, all numbers and figures; none if a run fails.
    """

    def read() -> Study:
        from microslip.report import Study

        return _with_figures(partial(Study.load, study), overrides, output.kinds)

    predict_into(read, output.folder or Path(f"{study.stem}-result"), output, workers)


@click.command(short_help="Predict a joint that comes with microslip.")
@switch("--beam", "A bolted beam: the damping of its modes, with bands.")
@_writes_into("microslip-demo")
def demo(beam: bool, output: Output) -> None:
    """Predict a milled aluminium joint, or a bolted beam, whose study comes with microslip.

    The folder holds the study, too: a copy of it is a good start for one of your own.
    """

    def read() -> Study:
        from microslip.report import Study

        name = "demo_beam.toml" if beam else "demo.toml"
        return Study.from_toml(demo_text(beam), name)

    predict_into(read, output.folder or Path("microslip-demo"), output)


def predict_into(read: Callable[[], Study], folder: Path, output: Output, workers: int = 1) -> None:
    """Compute a study, print its tables, and write its folder."""
    from microslip.report.folder import staged

    unprinted: OSError | None = None
    with stoppable():
        study = read()
        from microslip.report.predicted.numbers import KIND

        with staged(folder, output.overwrite, KIND, "result") as stage:
            from microslip.report.files import write_all
            from microslip.report.predicted.document import document
            from microslip.report.predicted.result import files
            from microslip.report.terminal import print_document, show_files

            with progress("Computing") as report:
                result = study.run(report, workers)
            if not output.as_json:
                # The numbers now, since writing may take longer; the files all the same, should
                # nobody be able to read them.
                try:
                    print_document(document(result), sys.stdout)
                    if sys.stdout is not None:
                        sys.stdout.flush()
                except OSError as error:
                    unprinted = error
            with progress("Drawing and writing") as report:
                write_all(files(result, folder), stage, report)
    if unprinted is not None:
        raise unprinted
    if output.as_json:
        echo_json(result.summary)
    else:
        show_files(result.summary["files"], folder, sys.stdout)


@click.command(short_help="Check a study without running it.")
@study_argument
@overridable
@switch("--json", "Print what was found as JSON, no tables.", "as_json")
def check(study: Path, overrides: tuple[str, ...], as_json: bool) -> None:
    """Check STUDY: its quantities in SI units, the joint at rest, validity. Writes nothing.

    Exit code 0 means that predict will run; doubtful assumptions are reported, but are no error.
    """
    with stoppable(), progress("Checking") as report:
        from microslip.report.predicted.preview import next_step, preview
        from microslip.study.build import check_draws
        from microslip.study.description import StudyDescription

        description = StudyDescription.load(study, overrides)
        look = preview(description, report)
        check_draws(description)
    if as_json:
        echo_json(look.data)
    else:
        from microslip.report.terminal import print_document, show_command

        words = [word for override in overrides for word in ("--set", override)]
        print_document(look, sys.stdout)
        command = command_line("microslip", "predict", study, *words)
        show_command(next_step(look), command, sys.stdout)


def _list_templates(context: click.Context, param: click.Parameter, value: bool) -> None:
    if value:
        for name, meaning in TEMPLATES.items():
            click.echo(f"{name:<10} {meaning}")
        from microslip.contact.finish import PROCESSES as TABLE

        click.echo("Faces for --process, by the Ra that they commonly have:")
        for name, process in TABLE.items():
            low, high = 1e6 * process.low, 1e6 * process.high
            click.echo(f"{name:<10} {low:g} to {high:g} um ({process.source})")
        context.exit()


@click.command(short_help="Write a study to begin with.")
@click.argument("name", metavar="NAME.toml", type=ANY_PATH)
@click.option(
    "--template", "kind", type=OneOf(tuple(TEMPLATES)), default="joint", show_default=True,
    help="Kind of study.",
)  # fmt: skip
@click.option(
    "--law",
    type=OneOf(TEMPLATE_LAWS),
    default=TEMPLATE_LAWS[0],
    show_default=True,
    help="Normal law of a joint.",
)
@click.option(
    "--list", is_flag=True, is_eager=True, expose_value=False, callback=_list_templates,
    help="List the templates, and the Ra by process.",
)  # fmt: skip
@click.option(
    "--process", type=OneOf(PROCESSES),
    help="Process that made the faces: bolted plates with the Ra that it commonly leaves.",
)  # fmt: skip
def new(name: Path, kind: str, law: str, process: str | None) -> None:
    """Write the study NAME.toml, commented; change it with any editor.

    Existing files are never changed.
    """
    if process is not None and (kind, law) != ("joint", TEMPLATE_LAWS[0]):
        raise click.UsageError("--process: wanted without --template and --law")
    steps = write_template(name, law, kind, process)
    click.echo(f"Written to {command_line(name)}. Next:")
    for step in steps:
        click.echo(f"  {step}")


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
    "Address of a Dask scheduler, which runs the items in place of --workers.",
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
    """Run all items of a FOLDER or a LIST: studies, records, scans, or changes to a study.

    A LIST is a text file with a path in each line, or a CSV table whose columns are keys of the
    study. Outcomes are saved one by one: after a stop the same command continues. Failures are
    listed with their reason and tried again by the next run.
    """
    with stoppable():
        from microslip.report.batched import finish
        from microslip.report.terminal import print_document
        from microslip.study.runs.batch import items_of, run_batch

        items = items_of(source, study)
        folder = folder or Path(f"{source.stem}-batch")
        with progress("Running") as report:
            outcomes = run_batch(items, folder, workers, dask, report)
        result = finish(outcomes, folder)
    if as_json:
        echo_json(result.data)
        return
    print_document(result, sys.stdout)
    click.echo(f"Results in {folder}")
