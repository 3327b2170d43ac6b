"""``python -m faces``: laws of faces against independent boundary elements, resumable."""

from __future__ import annotations

import argparse
import time

from .campaign import PRESSURES, Row, cases, compared, compared_scan, scans, table


def main() -> None:
    """Print the comparison of measured faces, drawings and scans."""
    parser = argparse.ArgumentParser(prog="python -m faces", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after these; go on later")
    given = parser.parse_args()
    end = time.monotonic() + 60.0 * given.minutes
    measured: list[Row] = []
    drawn: list[Row] = []
    for case in cases():
        if time.monotonic() > end:
            print(f"stopped after {len(measured)} of {len(cases())} cases")
            break
        for rows, row in zip((measured, drawn), compared(*case), strict=True):
            rows.append(row)
    for title, rows in (("measured", measured), ("drawn", drawn)):
        report(title, rows)
    report("scans", [compared_scan(name, p) for name in scans() for p in PRESSURES])


def report(title: str, rows: list[Row]) -> None:
    """Print the table of a law."""
    if rows:
        heading = f"\n{title}, law over boundary elements: median [range]\n"
        print("\n".join([heading, *table(rows)]), flush=True)


if __name__ == "__main__":
    main()
