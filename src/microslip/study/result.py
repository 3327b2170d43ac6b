"""What figures of the other products still take from here."""

from microslip.report.scales import evenly as some

__all__ = ["some"]
