"""Write the reference pages that follow from declarations: python docs/make_reference.py

``study-keys.md`` lists the keys of a study from its JSON Schema, ``command-options.md`` the options
of the command from click, ``results-names.md`` the quantities of a result from their table, and
``verdicts.md`` the limits of all verdicts from their rules. Explain keys, options, quantities and
limits where they are declared; the pages beside these are for prose.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from microslip._core.quantities import QUANTITIES
from microslip._core.verdicts import Rule
from microslip.cli import main as command
from microslip.study.json_schema import complete_schema

DOCS = Path(__file__).parent
NOTE = "<!-- Written by `python docs/make_reference.py` from the declarations; do not edit. -->\n"
UNIT = re.compile(r"\s*An? ([\w ]+?) with (?:its|a) unit, such as .*")
SCATTER = ({"low", "high"}, {"mean", "cv"}, {"values"})
COLUMN = {"file", "column"}


def cell(text: str) -> str:
    """Return text for a cell of a table."""
    return " ".join(text.split()).replace("|", r"\|")


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown, with a line below it."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cell(text) for text in line)} |\n" for line in lines) + "\n"


# -- keys of a study -------------------------------------------------------------------------------


def literal(value: Any) -> str:
    """Return a value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {literal(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else f"{value}"


def variants(schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the alternatives of a schema, which may be nested."""
    if "properties" in schema:
        return [schema]
    inner = [*schema.get("oneOf", ()), *schema.get("anyOf", ())]
    return [leaf for part in inner for leaf in variants(part)] if inner else [schema]


def is_scatter(schema: dict[str, Any]) -> bool:
    """Whether a table describes an uncertain number."""
    return set(schema.get("required", ())) in SCATTER and "properties" in schema


def is_column(schema: dict[str, Any]) -> bool:
    """Whether a table names a column of a CSV file."""
    return set(schema.get("required", ())) == COLUMN and set(schema["properties"]) == {
        *COLUMN,
        "unit",
    }


def limits(schema: dict[str, Any]) -> str:
    """Return the limits of a number in words."""
    words = (
        ("exclusiveMinimum", "above"),
        ("minimum", "at least"),
        ("exclusiveMaximum", "below"),
        ("maximum", "at most"),
    )
    found = [f"{word} {schema[key]:g}" for key, word in words if key in schema]
    return f" ({', '.join(found)})" if found else ""


def kind_of(schema: dict[str, Any]) -> str:
    """Return in words which values a key takes."""
    if "const" in schema:
        return f"`{literal(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{literal(value)}`" for value in schema["enum"])
    parts = variants(schema)
    if len(parts) > 1:
        kinds = [kind_of(part) for part in parts if not is_scatter(part)]
        words = " or ".join(dict.fromkeys(kinds))
        if any(map(is_scatter, parts)) and "(may be uncertain)" not in words:
            words += " (may be uncertain)"
        return words
    kind = "object" if "properties" in schema else schema.get("type")
    if kind == "array":
        return f"list of: {kind_of(schema.get('items', {}))}"
    if kind == "object":
        return "column of a CSV file" if is_column(schema) else "table"
    if kind in ("number", "integer"):
        return ("whole number" if kind == "integer" else "number") + limits(schema)
    if kind == "boolean":
        return "`true` or `false`"
    with_unit = UNIT.search(schema.get("description", ""))
    return with_unit[1] if with_unit else "text"


def tables_in(schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the tables that a key takes, alone or in a list."""
    found = []
    for part in variants(schema):
        part = part.get("items", part) if part.get("type") == "array" else part
        for leaf in variants(part):
            if leaf.get("properties") and not is_scatter(leaf) and not is_column(leaf):
                found.append(leaf)
    return found


def choice_of(schema: dict[str, Any]) -> str:
    """Return the key and value that select an alternative, such as ``law = "sphere"``."""
    for key, inner in schema["properties"].items():
        if key in ("law", "kind", "rigid") and "const" in inner:
            return f"{key} = {literal(inner['const'])}"
        if key == "law_file":
            return key
    return ""


def keys_page() -> str:
    """Return the page of the keys of a study."""
    parts = [
        "# Keys of a study\n\n" + NOTE + "\nHere you find the keys of a "
        "[study](study.md), table by table. "
        "Quantities are text with a unit. A value that may be uncertain can be a table, "
        "`{ low = …, high = … }`, `{ mean = …, cv = … }` or `{ values = […] }`.\n\n"
    ]
    seen: list[dict[str, Any]] = []

    def write(path: str, schema: dict[str, Any]) -> None:
        found = tables_in(schema)
        fresh = [part for part in found if part not in seen]
        seen.extend(fresh)
        for part in fresh:
            choice = choice_of(part) if len(found) > 1 else ""
            parts.append(f"## `[{path}]`" + (f" with `{choice}`" if choice else "") + "\n\n")
            if part.get("description"):
                parts.append(cell(part["description"]) + "\n\n")
            rows = []
            for key, inner in part["properties"].items():
                if choice.startswith(f"{key} ="):
                    continue  # it stands in the heading
                if "default" in inner:
                    absent = f"`{literal(inner['default'])}`"
                else:
                    absent = "required" if key in part.get("required", ()) else ""
                text = UNIT.sub("", inner.get("description", "")).strip()
                rows.append([f"`{key}`", kind_of(inner), text, absent])
            parts.append(table(["key", "value", "meaning", "if absent"], rows))
        for part in fresh:
            for key, inner in part["properties"].items():
                write(f"{path}.{key}", inner)

    top = complete_schema()["properties"]
    plain = [name for name, part in top.items() if not tables_in(part) and name != "material"]
    rows = [[f"`{n}`", kind_of(top[n]), top[n].get("description", "")] for n in plain]
    parts.append("## At the top\n\n" + table(["key", "value", "meaning"], rows))
    write("material.NAME", top["material"]["additionalProperties"])
    for name, part in top.items():
        if name not in plain and name != "material":
            write(name, part)
    return "".join(parts).rstrip() + "\n"


# -- options of the command ------------------------------------------------------------------------


def options_page() -> str:
    """Return the page of the commands with their arguments and options."""
    parts = [
        "# Options of the command\n\n" + NOTE + "\nHere you find what "
        "`microslip COMMAND --help` prints; "
        "[The command](command.md) shows how to use it.\n\n"
    ]

    def write(words: str, item: click.Command) -> None:
        context = click.Context(item, info_name=words)
        if isinstance(item, click.Group):
            for name in item.list_commands(context):
                inner = item.get_command(context, name)
                if inner is not None and not inner.hidden:
                    write(f"{words} {name}", inner)
            return
        usage = " ".join([words, *item.collect_usage_pieces(context)])
        parts.append(f"## {words.partition(' ')[2]}\n\n{cell(item.get_short_help_str(300))}\n\n")
        parts.append(f"`{usage}`\n\n")
        rows = []
        for option in item.get_params(context):
            record = option.get_help_record(context)
            if isinstance(option, click.Option) and record and "--help" not in option.opts:
                rows.append([f"`{record[0]}`", record[1]])
        if rows:
            parts.append(table(["option", "meaning"], rows))

    write("microslip", command)
    return "".join(parts).rstrip() + "\n"


# -- quantities of a result ------------------------------------------------------------------------


def names_page() -> str:
    """Return the page of the quantities in the files of a result."""
    rows = [
        [f"`{name}`", "–" if quantity.unit == "-" else quantity.unit, quantity.meaning]
        for name, quantity in QUANTITIES.items()
    ]
    return (
        "# Quantities of a result\n\n" + NOTE + "\nHere you find the columns "
        "of the tables, keys of "
        "`summary.json`, variables of `result.nc` and attributes of `ms.Result`, each with its "
        "unit; [Results](results.md) lists which file has which.\n\n"
        + table(["name", "unit", "meaning"], rows)
    ).rstrip() + "\n"


# -- verdicts --------------------------------------------------------------------------------------

RULES = {
    "Joints": ("contact.validity",),
    "Scans and summits": ("surfaces.scan_rules",),
    "Structures and their tests": (
        "structures.structure",
        "structures.modal_curve",
        "structures.random_vibration",
        "structures.reduction_identification",
    ),
    "Studies of a bolted structure": ("report.structure.judged",),
}


def rules_in(value: Any) -> Iterator[Rule]:
    """Yield the rules in a module, a collection of rules, or a rule itself."""
    if isinstance(value, Rule):
        yield value
    elif isinstance(value, (tuple, dict)):
        for item in value.values() if isinstance(value, dict) else value:
            yield from rules_in(item)


def short(limit: float) -> str:
    """Return a limit with three digits, large ones without an exponent."""
    return f"{limit:.3g}" if limit < 1000.0 else f"{limit:,.0f}"


def verdicts_page() -> str:
    """Return the page of the verdicts with their limits."""
    parts = [
        "# Verdicts and their limits\n\n" + NOTE + "\nHere you find the limits of every verdict: "
        "up to the first one the verdict is `ok`, beyond the second one `outside`, between them "
        "`watch`. [Validity](validity.md) explains the assumptions.\n\n"
    ]
    for heading, modules in RULES.items():
        rows = []
        for name in modules:
            for rule in rules_in(vars(importlib.import_module(f"microslip.{name}"))):
                good, bad = ("≥", "<") if rule.outside < rule.watch else ("≤", ">")
                limits = f"{good} {short(rule.watch)}", f"{bad} {short(rule.outside)}"
                rows.append([rule.name, rule.meaning, *limits, rule.remedy])
        parts.append(f"## {heading}\n\n")
        parts.append(table(["judged number", "assumption", "ok", "outside", "remedy"], rows))
    return "".join(parts).rstrip() + "\n"


PAGES = {
    "study-keys.md": keys_page,
    "command-options.md": options_page,
    "results-names.md": names_page,
    "verdicts.md": verdicts_page,
}


def main() -> None:
    """Write the pages."""
    for name, page in PAGES.items():
        (DOCS / name).write_text(page(), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
