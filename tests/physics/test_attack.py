"""A small part of the standing attack: ``make attack`` makes more inputs of the same kinds."""

from __future__ import annotations

import inspect
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attack import ATTACKS
from attack.campaign import LONGEST_MESSAGE, Tally, demand, run
from attack.entrances import entrances
from attack.files import placed
from attack.memory_by_rule import ExactContact
from attack.seeds import seeds
from attack.wrong_kinds import attack_argument
from usual import PAIR

import microslip as ms

NAMES = [name for name in ATTACKS if name != "disks"]
needs_signals = pytest.mark.skipif(os.name == "nt", reason="no alarms on this platform")


@needs_signals
@pytest.mark.parametrize("name", [name for name in NAMES if name != "files"])
def test_nothing_is_wrong(name: str) -> None:
    tally = run(ATTACKS[name].attack, 120, seed=1)
    assert tally.wrong == []
    assert tally.tried >= 120


@needs_signals
@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name != "kinds"])
def test_nothing_is_wrong_in_many(name: str) -> None:
    # Those take seconds a hundred; `make attack` makes many more of them.
    number = {"files": 600, "threads": 1000}.get(name, 3000)
    tally = run(ATTACKS[name].attack, number, seed=2)
    assert tally.wrong == []


@needs_signals
@pytest.mark.slow
@pytest.mark.parametrize("part", range(3))
def test_every_argument_is_given_every_kind(part: int) -> None:
    tally = Tally()
    for name, door in list(entrances().items())[part::3]:
        for argument in door.numeric:
            attack_argument(name, door, argument, tally)
    assert tally.wrong == []
    assert tally.tried > 10_000


@needs_signals
@pytest.mark.slow
def test_disks_and_kills() -> None:
    assert run(ATTACKS["disks"].attack, 6, seed=3).wrong == []


@needs_signals
def test_the_attack_sees_what_is_wrong() -> None:
    """Wrong answers, other errors, warnings, long messages and hangs all count."""

    def refuse_at_length() -> None:
        raise ms.InputError("x" * (LONGEST_MESSAGE + 1))

    tally = Tally()
    tally.attempt("wrong", lambda: demand(False, "not right"))
    tally.attempt("error", lambda: 1 / 0)
    tally.attempt("warning", lambda: np.float64(1.0) / np.float64(0.0))
    tally.attempt("long", refuse_at_length)
    assert [text.partition(":")[0] for text in tally.wrong] == ["wrong", "error", "warning", "long"]
    assert (tally.tried, tally.refused) == (4, 1)


@pytest.mark.slow
def test_files_are_sound_before_they_are_mutated(tmp_path: Path) -> None:
    for seed in seeds():
        path = placed(tmp_path, seed.name, seed.content)
        if seed.refused:
            with pytest.raises(ms.InputError):
                seed.read(path)
        else:
            assert seed.read(path) is not None


def test_the_rule_by_hand() -> None:
    """One sphere: mu N (1 - (1 - x)^1.5) on the first loading, Masing's rule after it."""
    joint = ms.Interface(ms.SphereOnFlat(PAIR, 5e-3), 0.5, separation=-1e-6)
    contact = ExactContact(joint)
    reach = joint.slip_per_indentation * 1e-6
    forces = [contact.step(-1e-6, share * reach) for share in (0.5, -0.5, 0.5, 2.0)]
    half, full = 1.0 - 0.5**1.5, 1.0
    wanted = joint.force_limit * np.array([half, -half, half, full])
    np.testing.assert_allclose(forces, wanted, rtol=1e-13)


# Made by the library and handed out, so that nobody else fills them in; readers of files, which are
# attacked by files; and what takes seconds a call and hands its arguments on to others here.
NOT_ENTERED = {
    *("BaseResponse", "RandomResponse", "ShockResponse"),
    *(
        "MeasuredContact.of_pieces",
        "NormalLaw.along",
        "Scan.to_contact",
    ),
    *(
        "AsperityFields",
        "Comparison",
        "Convergence",
        "CoupledCycle",
        "CoupledHarmonics",
    ),
    *("CoupledResponse", "FieldCycle", "FieldResponse", "ForcedResponse"),
    *(
        "FrequencyResponse",
        "FreeDecay",
        "HarmonicForce",
        "Identification",
        "IsotropicField",
        "IwanFit",
        "Measurement",
    ),
    *("MeshedJoint", "ModalCurve", "ModalIdentification", "Motion", "PeriodicResponse", "RingDown"),
    *("Preload", "Pressure", "ReducedJoint", "Sliders", "Summits"),
    *("FieldState", "State"),
    *("VectorCycle", "VectorResponse", "Verdict"),
    *("MeshedJoint.read", "ModalTest.read", "Record.read", "Scan.read"),
    "ReducedJoint.load",
    *("Drawing.converge", "Scan.changed"),
    *(f"NormalLaw.{quantity}" for quantity in ("contact_area", "contact_count")),  # so do these
    *("NormalLaw.contact_probability", "MeshedJoint.shank_sections"),
}


def test_every_callable_is_attacked() -> None:
    """All that takes a number and is public, constructors and methods included."""
    entered = {qualified(door.call) for door in entrances().values()} | NOT_ENTERED
    missing = []
    for name in ms.__all__:
        item = getattr(ms, name)
        if not callable(item) or (isinstance(item, type) and issubclass(item, Exception)):
            continue
        methods = [(name, item)]
        if isinstance(item, type):
            own = (key for key in dir(item) if not key.startswith(("_", "plot", "model_")))
            methods += [(f"{name}.{key}", getattr(item, key)) for key in own]
        for title, call in methods:
            if item is not ms.Study and takes_numbers(call):
                missing += [title] * (not {title, qualified(call)} & entered)
    assert not missing, "callables without an entrance in tests/attack"


def takes_numbers(call: Any) -> bool:
    try:
        parameters = inspect.signature(call).parameters if callable(call) else {}
    except ValueError:
        return False
    return any(
        re.search(r"\b(ArrayLike|float|int)\b", str(p.annotation)) for p in parameters.values()
    )


def qualified(call: Any) -> str:
    """Where a callable was written, whatever class or object hands it out."""
    return str(getattr(call, "__func__", call).__qualname__)


@pytest.mark.slow
def test_every_entrance_opens_to_its_own_arguments() -> None:
    for door in entrances().values():
        door.call(**door.arguments)
