"""Floor 6: measured surfaces, their summits and their statistics."""

from microslip.scans.combine import combine, moments_from
from microslip.scans.cutoffs import CutoffTable, default_cutoffs, over_cutoffs
from microslip.scans.distribution_fits import Fit
from microslip.scans.extreme_shares import ExtremeShares, extreme_shares
from microslip.scans.gap_table import GapTable, read_gap_table
from microslip.scans.height_distribution import HeightFit, height_distribution
from microslip.scans.moments import Moments
from microslip.scans.nayak import NayakSummits
from microslip.scans.patches import PatchErrors, cut, patch_errors
from microslip.scans.scan import Scan
from microslip.scans.spectrum import AxisSpectrum, Spectrum
from microslip.scans.statistics import Statistics
from microslip.scans.summit_statistics import SummitStatistics
from microslip.scans.summits import Summits, find_summits
from microslip.scans.synthesis import paraboloids, random_surface
from microslip.scans.verdicts import verdicts

__all__ = [
    "AxisSpectrum",
    "CutoffTable",
    "ExtremeShares",
    "Fit",
    "GapTable",
    "HeightFit",
    "Moments",
    "NayakSummits",
    "PatchErrors",
    "Scan",
    "Spectrum",
    "Statistics",
    "SummitStatistics",
    "Summits",
    "combine",
    "cut",
    "default_cutoffs",
    "extreme_shares",
    "find_summits",
    "height_distribution",
    "moments_from",
    "over_cutoffs",
    "paraboloids",
    "patch_errors",
    "random_surface",
    "read_gap_table",
    "verdicts",
]
