"""Floor 8: what all tables of a study have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from microslip._core.parameters import Parameter
from microslip._core.verdicts import Verdict
from microslip.errors import Argument, InputError, in_python, said

JsonSchema = dict[str, Any]


class KeyedError(ValueError):
    """Something wrong that only shows in the whole; it says at which key."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Part(BaseModel):
    """A table of a study file: frozen, and without keys that nobody reads."""

    model_config = ConfigDict(frozen=True, extra="forbid", revalidate_instances="always")


class SurfaceTable(Part):
    """Any table of a surface: what it adds to a result besides its normal law."""

    @property
    def law_name(self) -> str:
        """Name of the normal law that it gives."""
        return str(getattr(self, "law", ""))

    @property
    def apparent_area(self) -> float | None:
        """Apparent area [m^2], where there is one."""
        area: float | None = getattr(self, "area", None)
        return area

    def findings(self) -> dict[str, Any]:
        """What was found where its summits come from, in SI units, under a key of summary.json."""
        return {}

    def sentences(self) -> list[str]:
        """The same in words."""
        return []

    def verdicts(self) -> tuple[Verdict, ...]:
        """How far that bears a joint, apart from what its load decides."""
        return ()


@dataclass
class Reading:
    """Where a study is read from and what is to be told of it; pydantic's context."""

    folder: Path | None = None
    notes: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, info: ValidationInfo) -> Reading:
        """The context of a validator, or an empty one."""
        return info.context if isinstance(info.context, cls) else cls()

    def path(self, name: str) -> Path:
        """A file that the study names."""
        return (self.folder or Path()) / name

    def message(self, error: str, name: str) -> str:
        """What is wrong with a file, saying where it was looked for."""
        if self.folder is None or Path(name).is_absolute():
            return error
        return error.replace("no such file", "no such file in the folder of the study")


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


def required(description: str, example: str = "", **settings: Any) -> Any:
    """A key that has to be given: what it is, and an example as TOML."""
    return Field(description=description, examples=[example] if example else None, **settings)


def optional(description: str, example: str = "", default: Any = None, **settings: Any) -> Any:
    """A key that may be left out."""
    return required(description, example, default=default, **settings)


def key(option: Parameter, *checks: Any, **changes: Any) -> Any:
    """Key of a study for an option: its reading, default, description, example and schema."""
    settings: dict[str, Any] = {"description": option.sentence}
    if not option.required:
        settings["default"] = option.default
    if option.written:
        settings["examples"] = [option.written]
    info = Field(**{**settings, **changes})
    # Of several checks the last one comes first.
    info.metadata.extend([Check(_or_default(option), lambda _: option.schema()), *checks])
    return info


def _or_default(option: Parameter) -> Callable[[object], object]:
    """Reads a value; None, which only Python can give, is the default."""

    def read(raw_value: object) -> object:
        return None if raw_value is None and option.default is None else option.read(raw_value)

    return read


def as_key(argument: Argument) -> str:
    """An argument in a message as a study writes it."""
    if not argument.has_value:
        return argument.name
    return f"{argument.name} = {_as_toml(argument.value)}"


def keyed(error: InputError, table: str, otherwise: str = "") -> KeyedError:
    """An error of the physics at the key of its argument, or at another key of the table."""
    key = f"{table}.{error.argument or otherwise}".removesuffix(".")
    return KeyedError(key, said(error.statement, as_key))


def _as_toml(value: object) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_as_toml, value))}]"
    return str(value).lower() if isinstance(value, bool) else in_python(value)
