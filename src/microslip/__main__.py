"""What ``python -m microslip`` runs."""

from microslip.cli import main

if __name__ == "__main__":
    main(prog_name="microslip")
