"""microslip: the friction of rough, jointed surfaces by the Extended Greenwood Model."""

from microslip._core.packages import names_of_stub as _names
from microslip._version import __version__

REMOVED: dict[str, str] = {
    "GapTable": "use ms.GreenwoodWilliamson with ms.TabulatedHeights(-gaps[::-1], density[::-1])",
    "read_gap_table": "use ms.GreenwoodWilliamson with ms.TabulatedHeights(-gaps[::-1], "
    "density[::-1]), the arrays read by scipy.io.loadmat or numpy",
    "evaluate_to_zarr": "use ms.evaluate on a block of the grid at a time, and append with xarray",
    "Assembly": "use ReducedJoint.tightened: settled motion does not depend on the order",
    "PerssonCurve": "use ms.DrawnFace, or ms.MeasuredContact with a scan",
    "RoughSurface": "use ms.DrawnFace with rms, slope (Rdq of profiles) and tightening_pressure",
    "TightenedSurface": "use ms.DrawnFace or ms.MeasuredContact with tightening_pressure: "
    "faces yield by themselves",
    "SurfaceFinish": "use ms.Finish with ms.DrawnFace.from_finish",
    "EllipticSummits": "use a measured face with its direction, microslip.MeasuredContact",
    "sweep": "use ms.evaluate(surface=joint.surface, normal_load=loads[:, None], "
    "amplitude=..., ...); with arguments of xarray the results are labelled",
    "Sweep": "use the DataArrays that ms.evaluate returns for arguments of xarray",
    "first_loading": "use JointField(...).start().try_(displacement, separation)",
    "FirstLoading": "use JointField(...).start().try_(displacement, separation)",
    "Decay": "use Oscillator.ring_down, which has amplitude and damping of each cycle",
    "SegalmanFit": "fit chi and beta of ms.SegalmanIwan with SciPy as in docs/comparison.md",
    "BoucWen": "use ms.SegalmanIwan or ms.Iwan: every friction law is given by its backbone",
}
"""Public names of version 0.2 with their replacements. The next version drops this table."""

__getattr__, __dir__, __all__ = _names(__name__, __file__, removed=REMOVED)
__all__ = [*__all__, "__version__"]
