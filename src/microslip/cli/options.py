"""The options of commands, made from the options of the house, and how they are said."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microslip._core.parameters import Parameter
from microslip._core.units import Kind, QuantityError, Sign, ends_of, to_si
from microslip.cli.group import OneOf
from microslip.errors import UNSAID, Argument, Spelling

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any]
else:  # which takes no type before click 8.2
    _ParamType = click.ParamType

Command = Callable[..., Any]
Decorator = Callable[[Command], Command]

ANY_PATH = click.Path(path_type=Path, readable=False)
"""A path as it is given; what is wrong with it the house says itself."""


class _Value(_ParamType):
    """Reads one value of an option, with its unit."""

    def __init__(self, option: Parameter) -> None:
        self.option = option
        self.name = option.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value in SI units, or an error that names the option."""
        if not isinstance(value, str):
            return value
        try:
            return self.option.read_text(value)
        except ValueError as error:
            flag = param.opts[-1] if param is not None else self.option.name
            raise click.UsageError(f"{flag}: {error}", ctx) from None


class CommandOption(click.Option):
    """An option of a command that knows for which arguments of Python it stands."""

    def __init__(self, *args: Any, option: Parameter, **extra: Any) -> None:
        super().__init__(*args, **extra)
        self.option = option


class NamedOption(click.Option):
    """An option that stands for arguments of other names, with some values in words of its own."""

    def __init__(
        self,
        *args: Any,
        answers_for: tuple[str, ...] = (),
        words: Mapping[str, str] | None = None,
        **extra: Any,
    ) -> None:
        super().__init__(*args, **extra)
        self.answers_for = answers_for
        self.words = words or {}


def option(flag: str, value: str, text: str, name: str = "", **settings: Any) -> Decorator:
    """An option of one command: its flag, what stands for its value, its help."""
    names = [flag, name] if name else [flag]
    return click.option(*names, cls=NamedOption, metavar=value, help=text, **settings)


def switch(flag: str, text: str, name: str = "") -> Decorator:
    """An option without a value."""
    return click.option(*[flag, name] if name else [flag], is_flag=True, help=text)


def output_option(
    text: str, value: str = "DIR", name: str = "folder", **settings: Any
) -> Decorator:
    """The option that says where the files go."""
    names = ("-o", "--output", name)
    return click.option(*names, type=ANY_PATH, metavar=value, help=text, **settings)


def quantity(flag: str, text: str, kind: Kind, example: str, sign: Sign = "positive") -> float:
    """A value with its unit, in SI units, or an error that names the option."""
    try:
        return to_si(text, kind, example, sign)
    except QuantityError as error:
        raise click.UsageError(f"{flag}: {error}") from None


def ends_in(flag: str, text: str, form: str) -> tuple[str, str]:
    """The ends of LOW..HIGH, or an error that names the option."""
    ends = ends_of(text)
    if ends is None:
        raise click.UsageError(f'{flag} wants {form}, got "{text}"')
    return ends


JSON = switch("--json", "Print the summary as JSON, no tables.", "as_json")


def offers(*options: Parameter, **changes: Any) -> Decorator:
    """Give a command some options, in their order."""

    def give(command: Command) -> Command:
        for option in reversed(options):
            command = click.option(
                f"--{flag(option)}",
                option.name,
                cls=CommandOption,
                option=option,
                **{**_settings(option), **changes},
            )(command)
        return command

    return give


def flag(option: Parameter) -> str:
    """Name of an option on the command line, without its dashes."""
    return option.flag or option.name.replace("_", "-")


def _settings(option: Parameter) -> dict[str, Any]:
    if option.kind is bool:
        return {"is_flag": True, "help": option.sentence}
    settings: dict[str, Any] = {"help": option.sentence}
    if option.required:
        settings["required"] = True
    elif option.default is not None:
        settings |= {"default": option.default, "show_default": True}
    if option.choices and not option.none:
        return {**settings, "type": OneOf(option.choices)}
    settings |= {"type": _Value(option), "metavar": option.metavar or "VALUE"}
    low, high = option.items
    if high > 1:
        settings |= (
            {"nargs": high} if low == high else {"multiple": True, "callback": _values_or_none}
        )
    return settings


def _values_or_none(context: click.Context, param: click.Parameter, value: Any) -> Any:
    """The values of an option that may be repeated; None where it is not there."""
    return value or None


def spelling(context: click.Context | None) -> Spelling:
    """Spell arguments as a command does: as its options; without an option, as Python."""
    options: dict[str, click.Option] = {}
    for param in context.command.params if context is not None else ():
        if not isinstance(param, click.Option):
            continue
        names = [param.name]
        if isinstance(param, CommandOption):
            names += param.option.answers_for
        elif isinstance(param, NamedOption):
            names += param.answers_for
        options |= {name: param for name in names if name}

    def say(argument: Argument) -> str:
        param = options.get(argument.name)
        if param is None:
            # A name alone is the subject of a sentence, which may be no keyword at all.
            return f"in Python {argument}" if argument.has_value else argument.name
        name = param.opts[-1]
        if not argument.has_value:
            # Of a column that was read, its values are wrong and not its name.
            return argument.name if param.metavar == "COLUMN" else name
        if param.is_flag:
            return name
        if isinstance(param, NamedOption) and str(argument.value) in param.words:
            return f"{name} {param.words[str(argument.value)]}"
        return f"{name} {_words(argument.value, param, name)}"

    return say


def _words(value: Any, param: click.Option, name: str) -> str:
    """Metavariable of an option."""
    if value is UNSAID:
        return param.metavar or "VALUE"
    if value is False:
        return "none"
    if value is None and isinstance(param, CommandOption) and param.option.none:
        return param.option.none
    if isinstance(value, Mapping):
        pairs = (f"{key}={_range(item)}" for key, item in value.items())
        return f" {name} ".join(pairs)
    if isinstance(value, (list, tuple)):
        return (" " if param.nargs > 1 else f" {name} ").join(map(_word, value))
    return _word(value)


def _range(value: Any) -> str:
    if value is UNSAID:
        return "LOW..HIGH"
    return "..".join(map(_word, value)) if isinstance(value, (list, tuple)) else _word(value)


def _word(value: Any) -> str:
    if isinstance(value, slice):
        first = value.start if isinstance(value.start, str) else (value.start or 0) + 1
        value = f"{first}..{value.stop or ''}"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if shlex.quote(text) == text else f'"{text}"'
