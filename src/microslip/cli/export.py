"""The command ``export``: write the joint of a study as input of another program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microslip._core.options import option
from microslip._core.units import AREA, LENGTH, MASS_DENSITY
from microslip.cli.group import OneOf
from microslip.cli.options import Report, flag, offers, output_option, progress, stoppable, switch
from microslip.cli.studies import overridable, study_argument

if TYPE_CHECKING:
    from microslip.report import Study

EXPORT_KINDS = ("c", "abaqus-user", "fmu", "fmu3", "opensees", "calculix")
_OPTIONS = (
    option(
        "smallest_amplitude",
        "Smallest amplitude of cells and reported errors.",
        LENGTH,
        example="1 nm",
        metavar="LENGTH",
    ),
    option(
        "largest_amplitude",
        "Largest amplitude of cells and reported errors.",
        LENGTH,
        example="10 um",
        metavar="LENGTH",
    ),
    option("cells", "Number of Jenkins cells, for kinds made of cells.", int, default=50),
    option("depth", "Open reversals stored by exported code.", int, default=256),
    option(
        "element",
        "Directions of exported code: one or two along the surface, with or without separation.",
        choices=("joint", "contact", "planar", "planar-contact"),
        default="joint",
    ),
    option("size", "Number of nodes of an FMI 3 unit.", int, default=1),
    option("name", "Prefix of the names in the file.", default="joint"),
)
_CARD_OPTIONS = (
    option(
        "program",
        "Program for which a card is written.",
        choices=("abaqus", "calculix", "ansys", "code_aster", "moose", "openradioss", "ls-dyna"),
        flag="for",
    ),
    option(
        "units",
        "Units of a card: N m kg, N mm t, kN mm kg or lbf in.",
        choices=("m", "mm", "mm-ms", "in"),
    ),
    option("area", "Apparent area of a card, if the surface has none.", AREA, metavar="AREA"),
    option(
        "amplitude",
        "Slip amplitude of a card's layer.",
        LENGTH,
        metavar="LENGTH",
    ),
    option(
        "thickness",
        "Thickness of a card's layer; 1 mm if absent.",
        LENGTH,
        metavar="LENGTH",
    ),
    option("density", "Mass density of a card's layer.", MASS_DENSITY),
)


@click.command(short_help="Write the joint for another program.")
@click.argument("kind", type=OneOf((*EXPORT_KINDS, "card")), metavar="KIND")
@study_argument
@output_option("The file to write.", "FILE", "file", required=True)
@offers(*_OPTIONS, *_CARD_OPTIONS)
@switch("--overwrite", "Replace files that exist.")
@overridable
def export(
    kind: str,
    study: Path,
    file: Path,
    overwrite: bool,
    overrides: tuple[str, ...],
    **options: Any,
) -> None:
    """Write the joint of STUDY as input of another program.

    The header of the file states the errors of the exported joint. KIND c, abaqus-user, fmu,
    fmu3, opensees or calculix is the joint as code or elements of that program. KIND card is its
    contact properties per unit area, for the program given by --for.
    """
    of_card = {name: options.pop(name) for name in (item.name for item in _CARD_OPTIONS)}
    of_card = {name: value for name, value in of_card.items() if value is not None}
    with stoppable(), progress("Exporting") as report:
        from microslip.export import write
        from microslip.report import Study
        from microslip.study.uncertain import spreads_of

        described = Study.load(study, overrides)
        unsure = [key for key, _ in spreads_of(described)]
        law = _law(described, kind, report)
        if kind == "card":
            _write_card(law, file, overwrite, options["name"], of_card)
            return
        if of_card:
            flags = ", ".join("--" + flag(item) for item in _CARD_OPTIONS if item.name in of_card)
            raise click.UsageError(f"{flags}: requires kind card, got {kind}")
        exported = write(kind, law, file, overwrite=overwrite, **options)
    errors = exported.accuracy
    span = f"{errors.smallest_amplitude:.4g} to {errors.largest_amplitude:.4g} m"
    click.echo(f"Written: {', '.join(str(path) for path in exported.files)}")
    click.echo(
        f"From {span} the error is at most {errors.backbone_error:.2g} of the backbone and "
        f"{errors.energy_error:.2g} of the energy."
    )
    click.echo(f"Verification: {exported.run}.")
    if unsure:
        click.echo(f"Uncertain inputs are at their middle values: {', '.join(unsure)}.")


def _write_card(law: Any, file: Path, overwrite: bool, name: str, given: dict[str, Any]) -> None:
    from microslip.export import PROGRAMS, write_card

    if "program" not in given:
        programs = ", ".join(_CARD_OPTIONS[0].choices)
        raise click.UsageError(f"--for: wanted the program of the card, one of {programs}")
    program = given.pop("program")
    card = write_card(program, law, file, name=name, overwrite=overwrite, **given)
    click.echo(f"Written: {file}")
    click.echo(
        f"At {card.pressure:.4g} Pa: normal stiffness {card.normal_stiffness:.4g} Pa/m, tangential "
        f"stiffness {card.stick_stiffness:.4g} Pa/m, elastic slip {card.elastic_slip:.4g} m; the "
        f"stick-slip force exceeds the joint's by up to {100.0 * card.errors.force:.2g} %."
    )
    click.echo(f"Verification: {PROGRAMS[program].run}.")


def _law(study: Study, kind: str, report: Report) -> Any:
    from microslip._core.errors import StudyError
    from microslip.study.build import build_joints

    if study.structure is not None:
        raise StudyError(
            f"{study.name}: {kind} exports a joint, and this study describes a [structure]; omit "
            "that table, or call microslip.export.write with its JointField"
        )
    joints = build_joints(study, report)
    if len(joints) > 1:
        loads = ", ".join(f"{joint.normal_load:g}" for joint in joints)
        raise StudyError(
            f"{study.name}: joint.normal_load: a file contains one joint, got {len(joints)} loads "
            f"({loads} N); choose one, such as --set 'joint.normal_load=\"2 kN\"'"
        )
    return joints[0]
