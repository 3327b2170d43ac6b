"""Measurement of modal tests of a bolted structure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from microslip._core.units import FREQUENCY, with_common_unit
from microslip.cli.options import Output, click_option, progress, quantity, stoppable

BAND_OPTION = click_option(
    "--band", "LOW..HIGH",
    'Frequency band that contains the mode of a ring-down, such as "150..220 Hz".',
)  # fmt: skip


def are_modal(records: Sequence[str]) -> bool:
    """Return True if the files are tests of modes of a structure.

    Such tests are ring-downs, or tables of frequency and damping against amplitude.
    Raises UsageError if only some of the files are.
    """
    if not all(Path(record).is_file() for record in records):
        return False
    from microslip.structures.modal_test import modal_kind

    kinds = [modal_kind(record) for record in records]
    if any(kinds) and not all(kinds):
        first, second = (records[kinds.index(k)] for k in (next(filter(None, kinds)), None))
        raise click.UsageError(
            f"modal tests and records of loops must be measured separately: {first} is a "
            f"{next(filter(None, kinds))}, {second} is not a modal test"
        )
    return any(kinds)


def band_of(text: str | None) -> tuple[float, float] | None:
    """Parse a frequency band [Hz]; the unit may be given once."""
    if text is None:
        return None
    first, dots, last = (part.strip() for part in text.partition(".."))
    if not (first and dots and last):
        raise click.UsageError(f'--band: wanted LOW..HIGH, such as "150..220 Hz", got "{text}"')
    ends = with_common_unit((first, last))
    texts = [end if end[-1].isalpha() else f"{end} Hz" for end in ends]
    low, high = (quantity("--band", end, FREQUENCY, "150 Hz") for end in texts)
    if not low < high:
        raise click.UsageError(f'--band: wanted LOW below HIGH, got "{text}"')
    return low, high


def measure_modes(records: Sequence[str], output: Output, band: str | None) -> None:
    """Measure frequency and damping against amplitude from modal tests."""
    with stoppable():
        from microslip.report.files import write_document
        from microslip.report.modal_test import modal_test_document
        from microslip.structures import ModalTest

        within = band_of(band)
        with output.staged("modal-test") as stage, progress("Measuring") as report:
            tests = []
            for index, record in enumerate(records):
                tests.append(ModalTest.read(record, band=within))
                report((index + 1) / len(records))
            result_document = modal_test_document(tests)
            if stage is not None:
                result_document = write_document(result_document, stage, output.kinds)
    output.show(result_document)
