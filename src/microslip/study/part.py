"""Floor 8: what all tables of a study have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

JsonSchema = dict[str, Any]


class KeyedError(ValueError):
    """Something wrong that only shows in the whole; it says at which key."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Part(BaseModel):
    """A table of a study file: frozen, and without keys that nobody reads."""

    model_config = ConfigDict(frozen=True, extra="forbid", revalidate_instances="always")


@dataclass
class Reading:
    """Where a study is read from and what is to be told of it; pydantic's context."""

    folder: Path | None = None
    notes: list[str] = field(default_factory=list)


class Check(NamedTuple):
    """A check that comes before pydantic's own, and what the JSON Schema says of the value.

    `describe` is given the schema of the plain type.
    """

    check: Callable[[object], object]
    describe: Callable[[JsonSchema], JsonSchema]

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.check, handler(source))
