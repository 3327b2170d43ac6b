"""What `measure` finds in a record of a reciprocating rig, beside the same loops read by hand.

Nothing is predicted from inputs here: the case tests the evaluation of a real record, with its sign
inverted, a run-up and a compliant rig. Bands are the intervals of the means.
"""

from pathlib import Path

import microslip as ms

RECORD = Path(__file__).parents[3] / "shared" / "data" / "reciprocating" / "test_data_2.txt"


def predict() -> dict[str, tuple[float, float, float]]:
    """Return energy, peak friction and energy over the sliding distance."""
    if not RECORD.exists():
        raise FileNotFoundError(2, "missing", str(RECORD))
    mean = ms.measure(ms.Record.read(RECORD, sign=-1)).mean
    answers = {}
    for words, name in (
        ("energy of a cycle", "dissipated_energy"),
        ("peak friction over normal load", "friction_peak"),
        ("energy over 4 N times the sliding distance", "friction_energy"),
    ):
        answers[words] = (mean[name].low, mean[name].value, mean[name].high)
    return answers
