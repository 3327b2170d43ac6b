"""Entry point of ``python -m microslip.cli``."""

from microslip.cli import main

if __name__ == "__main__":
    main(prog_name="microslip")
