"""What to see in the figures of a prediction."""

from __future__ import annotations

from microslip.report.document import Picture
from microslip.results.predicted.figures import FIGURES, names
from microslip.results.predicted.prediction import Prediction
from microslip.results.predicted.varying import in_words


def pictures(result: Prediction) -> tuple[Picture, ...]:
    """The figures that a result has something to show in, in the order of reading."""
    figures = []
    for name in names(result):
        alternative, caption = _CAPTIONS[name]
        if result.study.excitation.load_varies:
            caption = _while_varying(result, name, caption)
        if result.scatter is not None:
            ends = (result.scatter.quantiles[0], result.scatter.quantiles[-1])
            between = " to ".join(f"{100.0 * end:g}" for end in ends)
            edges = "Dashed" if name == "loops" else "Shaded"
            if name in ("loops", "backbone", "energy_damping", "force_damping", "contact_state"):
                caption += f" {edges}: {between} % of what the uncertain numbers of the study do."
        figure = FIGURES[name]
        figures.append(Picture(name, caption, lambda figure=figure: figure(result), alternative))  # type: ignore[misc]
    return tuple(figures)


_PANELS = "one panel for each amplitude and one loop for each load"
# What holds of loops at constant normal load only, and what stands for it where that varies.
_OTHERWISE = (
    ("every loop follows", "every loop at constant load follows"),
    ("which no force amplitude passes", "which no force amplitude passes at constant load"),
    (
        "markers are the loops.",
        "filled markers are the loops, under a load that varies about the one named; hollow ones "
        "are at their amplitudes.",
    ),
)
_CAPTIONS = {
    "loops": (
        "Hysteresis loops, force against displacement",
        f"Closed hysteresis loops, {_PANELS}. Thin "
        "and pointed: most contacts stick (microslip). A parallelogram with flat ends: all slide. "
        "The area is the energy lost in a cycle.",
    ),
    "backbone": (
        "Force and stiffness of first loading against displacement",
        "First loading from rest (the backbone), from which every loop follows: its slope is kₜ "
        "while all sticks, and it ends at the force limit μN. Below, the tangent stiffness and the "
        "secant stiffness, which a linear model of the joint would have at that amplitude.",
    ),
    "energy_damping": (
        "Dissipated energy, loss factor and exponent against displacement amplitude",
        "Energy lost in a cycle, loss factor η with damping ratio ζ = η/2, and the local exponent "
        "of the energy, over the displacement amplitude; markers are the loops. The exponent is 3 "
        "in the microslip of a smooth backbone and 1 in gross slip.",
    ),
    "force_damping": (
        "Dissipated energy, loss factor and exponent against force amplitude",
        "The same over the force amplitude, as tests under force control show it. Dotted lines are "
        "the force limits μN, which no force amplitude passes; towards them energy and exponent "
        "rise steeply.",
    ),
    "contact_state": (
        "Contacts and real contact area against load, sticking share against displacement",
        "Contacts and real contact area over the normal load, with the loads of the study marked; "
        "below, the share of the contact area that still sticks after a displacement from rest.",
    ),
    "pressure": (
        "Pressure over the faces, and how near each place is to sliding",
        "The normal load as it is spread over the faces; below, the share of its own slip limit "
        "that each place carries after a displacement from rest: where little presses, all slides "
        "first, and slip reaches inwards from there as the displacement grows.",
    ),
    "slider_density": (
        "Slider density and share of the force limit against yield displacement",
        "The joint as a parallel Iwan model: the stiffness of its sliders per yield displacement, "
        "and the share of the force limit that the sliders up to a yield displacement carry.",
    ),
    "history": (
        "Displacement, force and dissipated energy along the history, and its path",
        "The own history from rest: displacement, force and energy lost so far over the samples, "
        "and the path that force and displacement take.",
    ),
    "oscillator": (
        "Frequency and damping of the oscillator against displacement amplitude",
        "A mass on a spring that the joint holds, too: its frequency, the shift of it, and the "
        "damping ratio of the mode (solid) beside the interface’s own (dashed). The two differ: "
        "energy is lost in the joint alone, but the whole mode stores it.",
    ),
}


def _while_varying(result: Prediction, name: str, caption: str) -> str:
    """The caption of a figure of a study in which the normal load varies somewhere."""
    variation = result.study.excitation.load_variation
    if name == "history":
        if result.histories[0].varying_normal_load is None:
            return f"{caption} The normal load is constant along it."
        return f"{caption} The normal load starts from that of the joint and follows the file."
    if name == "loops" and variation is not None:
        return (
            f"Closed hysteresis loops, {_PANELS}. The normal load varies over these cycles about "
            f"the one named: {in_words(variation)}. So the loops need not be symmetric. The area "
            "is the energy lost in a cycle."
        )
    if variation is not None:
        for constant, varying in _OTHERWISE:
            caption = caption.replace(constant, varying)
        if name in ("energy_damping", "force_damping"):
            return f"{caption} Lines and hollow markers are at constant normal load."
    return f"{caption} All this is at constant normal load."
