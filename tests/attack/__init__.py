"""A standing attack on everything public: any input is answered rightly or refused in one line."""

from __future__ import annotations

from typing import NamedTuple

from .campaign import Attack
from .disks import attack_disks
from .files import attack_files
from .histories import attack_histories, attack_states, attack_varying_loads
from .joints import attack_interfaces
from .threads import attack_threads
from .wrong_kinds import attack_wrong_kinds


class Campaign(NamedTuple):
    """An attack, its name on the page, and its share of all inputs."""

    title: str
    attack: Attack
    weight: float


ATTACKS = {
    "interfaces": Campaign("interfaces over the whole domain", attack_interfaces, 4),
    "histories": Campaign("histories at constant load", attack_histories, 4),
    "states": Campaign("operations on states in any order", attack_states, 2),
    "varying": Campaign("paths in separation and displacement", attack_varying_loads, 2),
    "kinds": Campaign("wrong kinds of input to every callable", attack_wrong_kinds, 12),
    "files": Campaign("mutated files of 39 formats", attack_files, 3),
    "disks": Campaign("full disks and kills", attack_disks, 0.001),
    "threads": Campaign("threads that share a joint", attack_threads, 0.2),
}
"""Every attack; a new one is a module and a line here."""
