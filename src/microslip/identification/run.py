"""From records to a law: the fit and the verdict on each number."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Progress, exact, number, positive, show
from microslip._core.errors import InputError
from microslip._core.threads import single_threaded
from microslip.contact import GreenwoodWilliamson
from microslip.contact.materials import MaterialPair
from microslip.identification import parameter_choice
from microslip.identification.caveats import Caveat
from microslip.identification.conclusions import Conclusions
from microslip.identification.coordinates import (
    FAR_SOFTER,
    gain_coordinate,
    rig_coordinates,
)
from microslip.identification.fit import Fit, solve
from microslip.identification.fit_quality import held_back_error
from microslip.identification.intervals import Profiled
from microslip.identification.models import model_of
from microslip.identification.models.base import Materials, Model
from microslip.identification.models.interface import InterfaceModel
from microslip.identification.nuisances import PLAY, play_of
from microslip.identification.options import LOSSES
from microslip.identification.other_laws import spread_over_laws
from microslip.identification.problem import Problem, checked_effects
from microslip.identification.quantities import known_data, quantities_of, summit_prior, summits_of
from microslip.identification.result import Identification
from microslip.laboratory.cycle_columns import checked_gains
from microslip.laboratory.cycles import check_direction
from microslip.laboratory.folding import MOST_BINS, averaged, stated_noise
from microslip.laboratory.folding import Folded as Folded
from microslip.laboratory.folding import fold as fold
from microslip.laboratory.record import Record

_MOST_FORCES = 1 << 15
_LEAST_CONFIDENCE = 1e-3
_MOST_DELAYS = 10
UNKNOWN = "unknown"
"""The number of summits is not known."""
INTERVALS = ("profile", "curvature")
_OF_ALL_LAWS = ("rig_stiffness", "rigs", "delay", "loss", "nuisances", "confidence", "gain_errors")
_IN_TIME, _LATEST = 1e-5, 1.0  # rad


@single_threaded
def identify(
    records: Record | Iterable[Record],
    law: Any = "interface",
    *,
    pair: MaterialPair | None = None,
    heights: Any = None,
    surface: Any = None,
    area: float | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    shared: Sequence[str] | None = None,
    per_load: Sequence[str] | None = None,
    rig_stiffness: Any = "free",
    rigs: Sequence[str] | None = None,
    delay: float | str = 0.0,
    loss: str = "linear",
    contact_area: tuple[float, float, float] | None = None,
    known: Mapping[str, tuple[float, float]] | None = None,
    summits: float | str | None = None,
    nuisances: Sequence[str] | None = None,
    cycles: slice | None = None,
    noise: tuple[float, float] | None = None,
    gain_errors: Mapping[str, float] | None = None,
    held_back: float = 0.25,
    confidence: float = 0.95,
    intervals: str = "profile",
    progress: Progress | None = None,
) -> Identification:
    """Find the parameters of a law from measured loops, and how sure they are.

    Parameters
    ----------
    records : Record or iterable of Record
        One or many, at several loads and amplitudes; each with at least three settled cycles.
    law : str, type or BackboneLaw, optional
        "interface", "jenkins", "iwan", "segalman", or the class. An instance also gives
        the values to start from; an Interface the shape of its heights and its materials, too.
    pair : MaterialPair, optional
        Materials, which turn the length kappa sigma into sigma. Loops alone do not need them.
    heights, surface : optional
        Distribution of heights, or a surface whose shape counts; without either, Gaussian heights.
    area : float, optional
        Apparent area [m^2], for densities of summits.
    fixed, start : mapping, optional
        Values of parameters by their names, which stay, or from which the fit starts.
    bounds : mapping, optional
        (lowest, highest) of parameters by their names.
    shared, per_load : sequence of str, optional
        Parameters that all loads share, or that each load has of its own. Without it an interface
        shares all, and other laws, which know no load, share none.
    rig_stiffness : str, float, tuple or None, optional
        Stiffness in series with the joint [N/m]: "free", a value, (value, uncertainty), or "rigid",
        which None and infinity say, too; a mapping of these by the labels of ``rigs``.
    rigs : sequence of str, optional
        Label of the rig of each record, where they are not all of one.
    delay : float or "free", optional
        Time [s] by which the force lags behind the displacement.
    loss : str, optional
        "linear", or one that bears outliers, forces more than about two standard deviations off:
        "soft_l1", "huber", "cauchy", "arctan", each with less weight to them than the one before.
    contact_area : tuple, optional
        Measured real contact area (value [m^2], uncertainty [m^2], normal load [N]): separates
        radius and density of the summits, which loops cannot.
    known : mapping, optional
        Data from elsewhere by the names of parameters or of what follows from them, as (value,
        standard deviation), such as ``{"std": (5e-7, 2e-8)}``, or as what has a ``value`` and a
        ``standard_error``. With ``pair`` and ``area`` a "radius" or a "density" of the summits
        separates the two, too.
    summits : float, optional
        Number of all summits under the apparent area [-]: as their heights are random, the tail
        that is in contact is not that of the distribution, and loops tell the heights, and with
        them the rig, less well. Without it that of the surface that was given counts, or of a
        known density and ``area``; without these, or with "unknown", they are found as if heights
        were a continuum and are apparent; infinity says that heights are one, such as those of a
        virtual joint.
    nuisances : sequence of str, optional
        Forces beside the law whose sizes are free in each record: "parallel" (a spring beside the
        joint), "viscous", "inertia" (a mass behind the force sensor; of a sine it is the same as
        "parallel"), "tilt" (friction changes along the way; to first order); or "play" between
        joint and transducer, one for all records. A note says where one that was not asked for
        would explain most of what the law leaves.
    cycles : slice, optional
        Cycles to take of each record, the first being 0; without it all settled ones but the first.
    noise : (float, float), optional
        Standard deviations of each force [N] and each displacement [m]: then every record is one
        cycle that was averaged already, of which no scatter tells the noise; none is held back.
    gain_errors : mapping, optional
        Relative standard deviations [-] of the gains of the sensors, as their calibration has them,
        by "force", "displacement" and "normal_load": errors that all cycles and records share.
    held_back : float, optional
        Share of the cycles [-] that a second fit does not see and predicts; 0 for none. At least
        one cycle of each record is held back, and two are not.
    confidence : float, optional
        Level of the intervals [-].
    intervals : str, optional
        "profile", or "curvature", which is quick: intervals as if the law were linear in its
        parameters.
    progress : callable, optional
        Called now and then with the share that is done, 0 ... 1.

    Returns
    -------
    Identification
        Values with profile intervals, verdicts, residuals; whether it converged is its status.

    Notes
    -----
    What Fig. 19.22 of the chapter (DOI 10.1007/978-3-319-56818-8_19) does by eye, with the rig and
    the noise in it. Weighted least squares on the mean cycle of each record. The displacement is a
    Fourier series, with corners where a drive has some, whose errors count (generalised least
    squares); half distances are those of the measured displacement, so that Masing's rules hold for
    joint and rig in series: T = T0(v), v + T0(v)/k = y. The force's offset is free in each record;
    a straight drift of the force or the displacement is taken off, and its error counts, as does
    that of the mean load of a record whose load is a channel (a load that is given as one number is
    taken to be exact). Intervals are those of the profile likelihood, widened by the root of the
    reduced chi-squared where that exceeds 1 significantly, or by the scatter of whole cycles
    (Huber's sandwich) where that is larger.
    """
    stated = locals().copy()
    report = _reporter(progress)
    level = _checked_share("confidence", confidence)
    if level < _LEAST_CONFIDENCE:
        raise InputError(f"`confidence` must be at least {_LEAST_CONFIDENCE:g}, got {exact(level)}")
    if not isinstance(loss, str) or loss not in LOSSES:
        raise InputError(f"`loss` must be one of {', '.join(LOSSES)}, got {show(loss)}")
    if not isinstance(intervals, str) or intervals not in INTERVALS:
        allowed = ", ".join(map(repr, INTERVALS))
        raise InputError(f"`intervals` must be one of {allowed}, got {show(intervals)}")
    held_share = number("held_back", held_back, "", 0.25)
    held_share = 0.0 if held_share == 0.0 else _checked_share("held_back", held_share)
    folded = fold_all(records, cycles, lambda share: report(0.3 * share), noise)
    held_share = held_share if all(record.cycles > 1 for record in folded) else 0.0
    options = {"heights": heights, "surface": surface}
    model = model_of(law, **{key: value for key, value in options.items() if value is not None})
    parameter_choice.checked_loads(model, folded)
    materials = _materials_of(pair, area, model, surface)
    loops = [record.loop for record in folded]
    model = model.prepared(loops, [record.normal_load for record in folded])
    notes: list[Caveat] = []
    coordinates, columns, start_values = parameter_choice.coordinates_for(
        model, folded, fixed=fixed, bounds=bounds, start=start, shared=shared, per_load=per_load
    )
    model = parameter_choice.split_model(model, coordinates)
    stiffnesses, rig_of = rig_coordinates(rig_stiffness, rigs, loops, bounds)
    places = [None if rig is None else len(coordinates) + rig for rig in rig_of]
    coordinates = [*coordinates, *stiffnesses]
    count_of_summits = _checked_summits(summits, model, known, materials.area, notes)
    summit_coordinate, known = summit_prior(contact_area, known, model, materials)
    if summit_coordinate is not None:
        coordinates.append(summit_coordinate)
    gains = checked_gains(gain_errors)
    if gains.get("displacement"):
        coordinates.append(gain_coordinate(gains["displacement"]))
    effects = checked_effects(nuisances)
    problem = Problem(
        *(folded, model, coordinates, columns, places),
        free_delay=isinstance(delay, str) and delay == "free",
        lags=_checked_lags(delay, folded),
        summits=count_of_summits,
        gains=gains,
        effects=tuple(name for name in effects if name != PLAY),
        materials=materials,
    )
    if soft := problem.soft_rig(FAR_SOFTER):
        raise InputError(soft.words())
    problem.quantities = quantities_of(problem)
    if summit_coordinate is not None:
        problem.quantities += summits_of(problem, summit_coordinate.load)
    problem.data = known_data(problem, known)
    if problem.freedom < 1:
        raise InputError(
            f"{problem.free.size} parameters are too many for {problem.count} forces; fix or share "
            "some"
        )
    best = solve(problem, parameter_choice.starts_for(problem, start_values), loss)
    if best is None:
        if soft := problem.soft_rig():
            raise InputError(soft.words())
        raise InputError(
            "no start values follow from these records; give `start=...` for "
            f"{', '.join(model.names)}"
        )
    if problem.free_delay:
        best = _with_delays(best, loss)
    if PLAY in effects:
        best, of_play = _with_play(best, loss)
        notes.append(of_play)
    report(0.5)
    answer = Profiled(best, level, lambda share: report(0.5 + 0.4 * share), intervals)
    predicted = None
    if held_share and answer.best.finite:
        predicted = held_back_error(answer.best, held_share)
    report(1.0)
    result = Conclusions(answer, loss).result(notes, predicted)
    if not result.converged and any(note.kind == "summits taken" for note in notes):
        # A missing number of summits does not stop the fit; its numbers are then apparent.
        return identify(**stated | {"records": folded, "summits": UNKNOWN})
    if intervals == "curvature" or not isinstance(model, InterfaceModel):
        return result
    further = {name: value for name, value in (fixed or {}).items() if name not in model.names}
    options = {key: stated[key] for key in _OF_ALL_LAWS} | {"fixed": further, "held_back": 0}

    def refit(other_law: str, **law_options: Any) -> Identification:
        return identify(folded, other_law, **options, **law_options)  # type: ignore[arg-type]

    return spread_over_laws(result, refit)


# -- what was given -------------------------------------------------------------------------------


def _reporter(progress: Progress | None) -> Progress:
    if progress is None:
        return lambda share: None
    if not callable(progress):
        raise InputError(f"`progress` must be a function of the share done, got {show(progress)}")
    return progress


def _checked_share(name: str, raw_value: Any) -> float:
    value = number(name, raw_value, "", 0.25)
    if not 0.0 < value < 1.0:
        raise InputError(f"`{name}` must be between 0 and 1, got {exact(value)}")
    return value


def fold_all(
    records: Any, cycles: slice | None, report: Progress, noise: tuple[float, float] | None = None
) -> list[Folded]:
    """The records, each on one cycle; those that are there already, as they are."""
    if isinstance(records, list) and records and isinstance(records[0], Folded):
        return records
    records = parameter_choice.record_list(records)
    bins = max(64, min(MOST_BINS, _MOST_FORCES // len(records)))
    stated = None if noise is None else stated_noise(noise)
    if stated is not None and cycles is not None:
        raise InputError(
            "`cycles` and `noise` contradict each other: an averaged loop is one cycle"
        )
    folded = []
    for at, record in enumerate(records):
        one_cycle = fold(record, cycles, bins) if stated is None else averaged(record, stated, bins)
        x, force, way = one_cycle.displacement(one_cycle.phase), one_cycle.force, one_cycle.way
        error = one_cycle.force_noise * float(np.linalg.norm(way / np.sqrt(one_cycle.count)))
        check_direction(one_cycle.name, float(force @ way), error, x, force)
        folded.append(one_cycle)
        report((at + 1) / len(records))
    names = [record.name for record in folded]
    if len(set(names)) < len(names):
        folded = [replace(record, name=f"{record.name} {i + 1}") for i, record in enumerate(folded)]
    return folded


def _materials_of(pair: Any, area: Any, model: Model, surface: Any) -> Materials:
    """Materials given, else those of the joint, else those of the surface."""
    area = None if area is None else positive("area", area, "m^2", 2e-4)
    pair, area, _ = model.completed(Materials(pair, area))
    pair, area = pair or getattr(surface, "pair", None), area or getattr(surface, "area", None)
    if pair is not None and not isinstance(pair, MaterialPair):
        raise InputError(f"`pair` must be a MaterialPair of two materials, got {show(pair)}")
    return Materials(pair, area)


def _checked_summits(
    count: Any,
    model: Model,
    known: Mapping[str, Any] | None,
    area: float | None,
    notes: list[Caveat],
) -> float | None:
    """Number of summits, where the law has a distribution of their heights.

    As stated, else as the surface that was given or a density known from elsewhere has it.
    """
    if isinstance(count, float) and count == math.inf:
        return None
    is_unknown = isinstance(count, str) and count == UNKNOWN
    template = getattr(model, "template", None)
    if template is None or not isinstance(template.law, GreenwoodWilliamson):
        if count is not None:
            raise InputError(
                '`summits` needs `law="interface"` with a distribution of summit heights: other '
                "laws have no random summits"
            )
        return None
    if count is not None and not is_unknown:
        return positive("summits", count, "", 2e4)
    law, density = getattr(model, "law", None), (known or {}).get("density")
    found = None if law is None else law.surface.density * law.surface.area
    if density is not None and area is not None:
        found = area * (density.value if hasattr(density, "value") else density[0])
    if found is None or is_unknown:
        notes.append(Caveat("continuum", {"count": "..."}))
        return None
    source = "the surface given" if density is None else "the density given and the area"
    notes.append(Caveat("summits taken", {"count": f"{found:.4g}", "source": source}))
    return positive("summits", found, "", 2e4)


def _checked_lags(delay: Any, folded: Sequence[Folded]) -> list[float]:
    """Phases [rad] by which forces lag behind; 0 to begin with where they are free."""
    if isinstance(delay, str) and delay != "free":
        raise InputError(f"`delay` must be a time [s] or 'free', got {show(delay)}")
    lag = 0.0 if isinstance(delay, str) else number("delay", delay, "s")
    if lag != 0.0 and any(record.frequency is None for record in folded):
        raise InputError('delay needs records with time or sample_rate; or write `delay="free"`')
    for folded_record in folded:
        if folded_record.frequency is not None and abs(lag) * folded_record.frequency > 0.5:
            raise InputError(
                f"`delay` must be within half a period, {0.5 / folded_record.frequency:.4g} s at "
                f"{folded_record.frequency:.4g} Hz, got {lag:g} s"
            )
    return [2.0 * math.pi * (record.frequency or 0.0) * lag for record in folded]


def _with_play(best: Fit, loss: str) -> tuple[Fit, Caveat]:
    """The fit with the play of the rig taken off, and what to say of it."""
    error = 0.0
    for _ in range(2):  # by the weights of the fit without play, then by its own
        play = play_of(best)
        if play.explained <= 0.0:
            break
        error = play.error
        folded = [replace(f, play=play.value, play_error=error) for f in best.problem.folded]
        solution = solve(best.problem.like(folded=folded), [best.q], loss)
        if solution is None or not solution.finite:
            break
        best = solution
    value = best.problem.folded[0].play
    if value <= 2.0 * error or value == 0.0:
        return best, Caveat("no play")
    return best, Caveat("play", {"play": 2.0 * value, "error": 2.0 * error})


def _with_delays(best: Fit, loss: str) -> Fit:
    """The fit with each force as late as it wants to be; the rest of it is a linear nuisance."""
    for _ in range(_MOST_DELAYS):
        lags = best.problem.lags_at(best.q)
        moved = max(abs(a - b) for a, b in zip(lags, best.problem.lags, strict=True))
        if moved < _IN_TIME or not moved < _LATEST:
            break
        solution = solve(best.problem.like(lags=lags), [best.q], loss)
        if solution is None or not solution.finite:
            break
        best = solution
    return best
