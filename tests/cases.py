"""Reference cases and the interfaces made of them, shared by the tests."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from own_laws import LAWS

import microslip as ms
from microslip.readers.files import decoded

Case = dict[str, Any]

REFERENCE = Path(__file__).parent / "reference"
# A second set of numbers, made by other hands, that may lie beside the repository.
SHARED = Path(__file__).resolve().parents[2] / "shared" / "reference" / "interfaces.json"


@lru_cache
def own_cases() -> tuple[Case, ...]:
    """The cases of tests/reference/make_reference.py."""
    text = (REFERENCE / "interfaces.json").read_text(encoding="utf-8")
    return tuple(json.loads(text)["cases"])


@lru_cache
def shared_cases() -> tuple[Case, ...]:
    """The cases beside the repository, in the layout of the project's own; none where absent."""
    if not SHARED.is_file():
        return ()
    return tuple(_own_layout(case) for case in json.loads(SHARED.read_text(encoding="utf-8")))


def _own_layout(case: Case) -> Case:
    result = dict(case["result"])
    rows = result["amplitudes"]
    result["amplitudes"] = {key: [row[key] for row in rows] for key in rows[0]}
    heights = dict(case["heights"])
    if heights["kind"] == "population":
        heights["kind"] = "summits"
    return {**case, "heights": heights, "result": result}


def case_params(*, shared: bool = True) -> list[Any]:
    """Cases for ``pytest.mark.parametrize``; what is absent shows as one skipped test."""
    params = [pytest.param(case, id=case["name"]) for case in own_cases()]
    if not shared:
        return params
    others = [pytest.param(case, id=f"shared-{case['name']}") for case in shared_cases()]
    reason = "no reference/interfaces.json in a folder `shared` beside the repository"
    return params + (others or [pytest.param({}, id="shared", marks=pytest.mark.skip(reason))])


def own_case(name: str) -> Case:
    """One of the project's own cases by its name."""
    return next(case for case in own_cases() if case["name"] == name)


def pair_of(case: Case) -> ms.MaterialPair:
    """The two materials of a case."""
    bodies = [
        ms.Material.rigid() if body.get("rigid") else ms.Material(**body)
        for body in case["materials"]
    ]
    return ms.MaterialPair(*bodies)


def surface_of(case: Case) -> ms.NormalLaw:
    """The normal load law of a case."""
    pair, heights = pair_of(case), case["heights"]
    if heights["kind"] == "sphere":
        return ms.SphereOnFlat(pair, radius=case["radius"])
    if heights["kind"] == "summits":
        return ms.AsperityPopulation(pair, heights=heights["values"], radii=heights["radii"])
    distribution: ms.HeightDistribution
    if heights["kind"] == "gaussian":
        distribution = ms.Gaussian(std=heights["std"], mean=heights.get("mean", 0.0))
    else:
        distribution = ms.Exponential(scale=heights["scale"])
    return ms.GreenwoodWilliamson(
        pair, distribution, radius=case["radius"], density=case["density"], area=case["area"]
    )


def interface_of(case: Case) -> ms.Interface:
    """The joint of a case, at its load or its separation."""
    held = {key: case[key] for key in ("normal_load", "separation") if key in case}
    return ms.Interface(surface_of(case), case["friction_coefficient"], **held)


def length_of(case: Case) -> float:
    """The length that measures separations of a case [m]: sigma, or what stands for it."""
    heights = case["heights"]
    return float(heights.get("std", heights.get("scale", 0.0)))


# What the shared tests run over


def law_params(*, which: Callable[[ms.BackboneLaw], bool] = lambda law: True) -> list[Any]:
    """Every example of every backbone law, for ``pytest.mark.parametrize``; or those asked for."""
    return [
        pytest.param(law, id=f"{cls.__name__}-{i}", marks=_marks(cls, i))
        for cls in LAWS
        for i, law in enumerate(cls.examples())
        if which(law)
    ]


def joint_params(*, which: Callable[[ms.Interface], bool] = lambda joint: True) -> list[Any]:
    """Every example of an interface; or those asked for."""
    return [
        pytest.param(joint, id=f"Interface-{i}", marks=_marks(ms.Interface, i))
        for i, joint in enumerate(ms.Interface.examples())
        if which(joint)
    ]


def _marks(cls: type, index: int) -> tuple[pytest.MarkDecorator, ...]:
    """Every surface stands at three loads, of which the default suite takes one in turn."""
    surface, load = divmod(index - 1, 3)
    quick = cls is not ms.Interface or index == 0 or load == surface % 3
    return () if quick else (pytest.mark.slow,)


def is_elastic(law: ms.BackboneLaw) -> bool:
    """Whether a law moves before it slips: Coulomb's has no inverse and no scale of length."""
    return math.isfinite(law.tangential_stiffness)


def is_curved(law: ms.BackboneLaw) -> bool:
    """Whether a law has sliders that are spread."""
    return law.sliders()._density is not None


def is_polygon(law: ms.BackboneLaw) -> bool:
    """Whether a law is a polygon that begins with a spring."""
    return is_elastic(law) and not is_curved(law)


all_laws = pytest.mark.parametrize("law", law_params())
invertible_laws = pytest.mark.parametrize("law", law_params(which=is_elastic))
every_joint = pytest.mark.parametrize("joint", joint_params())


def reach_of(law: ms.BackboneLaw) -> float:
    """Displacement [m] at which the first tangent of a law meets its force limit."""
    if not is_elastic(law):
        return 1e-6  # any will do
    return law.force_limit / law.tangential_stiffness


def stiffness_of(law: ms.BackboneLaw) -> float:
    """Stiffness [N/m] by which errors of stiffnesses are measured; none for a rigid law."""
    return law.tangential_stiffness if is_elastic(law) else 0.0


def missing_share(law: ms.BackboneLaw, amplitude: float) -> float:
    """How much a concave backbone may lack of E_d = 4 F a, as its own values bound it.

    The integral of T0 up to a is no less than (a - m) T0(m) for any m.
    """
    middles = amplitude * np.geomspace(1e-12, 1.0, 2000)
    least = np.max((1.0 - middles / amplitude) * law.backbone(middles)) / law.force_limit
    return float(2.0 * (1.0 - least))


def closest(surface: ms.NormalLaw) -> float:
    """Separation [m] below which a surface has no answer: a table's first."""
    if isinstance(surface, ms.TabulatedNormalLaw):
        return float(surface.separations[0])
    return -math.inf


def ends_below(joint: ms.Interface) -> bool:
    """Whether there is such a separation."""
    return math.isfinite(closest(joint.surface))


def settled(v: float) -> float:
    """Nothing, or so much that its cube times a load does not underflow."""
    return v if abs(v) > 1e-15 else 0.0


# Multiples of a law's reach. Eighths make a record turn and close where it was before.
moves = st.one_of(
    st.integers(-16, 16).map(lambda k: k / 8),
    st.floats(-3.0, 3.0).map(settled),
    st.sampled_from([1e-12, -1e-7, 1e-3, 25.0, -25.0, 400.0]),
)


def records(min_size: int = 1, max_size: int = 30) -> st.SearchStrategy[Any]:
    """Displacement records in multiples of a law's reach, with ties, repeats and gross slip."""
    return st.lists(moves, min_size=min_size, max_size=max_size).map(np.array)


def folded(
    name: str, cases: Mapping[str, Any], *, whole: bool = False, **axes: Iterable[Any]
) -> Callable[..., Any]:
    """Run a test over all cases of a class in one go, or over all of them, and over other axes.

    Thousands of tests that differ by an example alone cost more to collect and report than to run.
    What fails says in which case. Labels begin with the name of the class.
    """
    groups: dict[str, list[str]] = {}
    for label in cases:
        groups.setdefault(
            "all" if whole else re.match(r"[A-Za-z -]*", label)[0].strip(), []
        ).append(label)  # type: ignore[index]

    def decorate(test: Callable[..., None]) -> Any:
        def run(group: str) -> None:
            combinations = list(itertools.product(*axes.values()))
            for label in groups[group]:
                for values in combinations:
                    try:
                        test(**{name: cases[label]}, **dict(zip(axes, values, strict=True)))
                    except pytest.skip.Exception:
                        continue
                    except BaseException as error:
                        error.add_note(f"in the case {label} {values if values else ''}")
                        raise

        run.__name__, run.__doc__ = test.__name__, test.__doc__
        return pytest.mark.parametrize("group", groups)(run)

    return decorate


def refusal(call: Callable[..., Any], *args: Any, **kwargs: Any) -> str:
    """The one line with which a call is refused."""
    with pytest.raises(ms.InputError) as caught:
        call(*args, **kwargs)
    message = str(caught.value)
    assert "\n" not in message
    return message


def parsed_here(kind: str, path: Path, reader: Callable[..., Any], **options: Any) -> Any:
    """What `readers.child.parsed` does, in this process, where a test stands in for a library."""
    for name in ("libraries", "bytes_a_second"):
        options.pop(name, None)
    with decoded(kind):
        return reader(path, **options)
