"""Records of test rigs, and the hysteresis loops in them."""

from microslip._core.packages import names_of_stub as _names

# Commands read their options here before the modules that do the work are loaded.
__getattr__, __dir__, __all__ = _names(
    __name__,
    __file__,
    removed={
        "delay_of": "a note of microslip.measure gives the delay; delay=... removes it",
        "Thresholds": "regimes are those of one sphere, microslip.laboratory.measurement",
        "rate_dependence": "use numpy.polyfit of ln(energy) over lg(frequency), campaign.csv",
        "rig_stiffness_of": "loops cannot separate rig and joint; measure a rigid specimen",
    },
)
