"""Entry point of ``microslip`` and ``python -m microslip``."""

import sys

from microslip._core.packages import MissingPackageError, needed_for


def main() -> None:
    """Run the command, or print in one line which package is missing."""
    try:
        with needed_for("the command microslip needs"):
            from microslip.cli import main as command
    except MissingPackageError as missing:
        print(f"error: {missing}", file=sys.stderr)
        sys.exit(2)
    command(prog_name="microslip")


if __name__ == "__main__":
    main()
