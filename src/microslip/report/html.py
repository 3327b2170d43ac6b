"""Self-contained HTML5 page of a document."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import singledispatch
from html import escape
from itertools import count
from pathlib import Path

from microslip._version import __version__
from microslip.figures.picture import Picture, figure_element, script
from microslip.report.cells import HEADLINES, NO_LIMITS, as_text, judgements, signed
from microslip.report.document import (
    Block,
    Document,
    Items,
    Note,
    Section,
    Table,
    Verdicts,
)

_SIGNS = {"ok": "✓", "watch": "!", "outside": "✗", "not judged": "?", "none": "?"}


def html_page(document: Document) -> str:
    """Return the text of the HTML page of a document."""
    style = Path(__file__).with_name("page.css").read_text(encoding="utf-8")
    title = escape(document.title)
    lead = [picture for picture in document.pictures if picture.name == document.figure]
    pruned = [_pruned(section, lead) for section in document.sections]
    sections = [*(section for section in pruned if section.blocks), *_provenance(document)]
    code = script("ticks.js") + script("figure.js")
    # The policy allows only this script, whatever the page contains.
    hashed = base64.b64encode(hashlib.sha256(code.encode("utf-8")).digest()).decode("ascii")
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
    policy += f"script-src 'sha256-{hashed}'"
    return "".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
            f'<meta name="generator" content="microslip {__version__}">\n'
            f"<title>{title} – microslip</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
            f"<header>\n<h1>{title}</h1>\n<p class='answer'>{escape(document.answer)}</p>\n",
            *_banner(document),
            *(figure_element(picture, 1) for picture in lead),
            '<nav aria-label="Sections">',
            *(f'<a href="#{anchor(s.title)}">{escape(s.title)}</a>' for s in sections),
            "</nav>\n</header>\n<main>\n",
            *_sections(sections, len(lead)),
            f"</main>\n<script>{code}</script>\n</body>\n</html>\n",
        )
    )


def _pruned(section: Section, pictures: list[Picture]) -> Section:
    names = [picture.name for picture in pictures]
    blocks = (b for b in section.blocks if not (isinstance(b, Picture) and b.name in names))
    return replace(section, blocks=tuple(blocks))


def anchor(title: str) -> str:
    """Return the anchor (fragment identifier) of a section title."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _banner(document: Document) -> Iterator[str]:
    if not document.verdicts and not document.remarks:
        return
    judged = [judgement for block in document.verdicts for judgement in judgements(block)]
    # Without rules no assumption is reported as fulfilled.
    word = document.word if judged else "none"
    head = HEADLINES[word] if judged else NO_LIMITS
    look = word if document.verdicts else "watch"
    yield f'<div class="verdict {anchor(look)}">\n'
    if document.verdicts:
        yield f"<p><strong>{_SIGNS[word]} {escape(head)}</strong></p>\n"
    doubts = [judgement.sentence for judgement in judged if judgement.word != "ok"]
    if doubts:
        yield _list(doubts)
    for remark in document.remarks:
        yield f'<p class="small">{escape(remark)}</p>\n'
    yield "</div>\n"


def _sections(sections: list[Section], lead_count: int) -> Iterator[str]:
    numbers = count(lead_count + 1)
    for section in sections:
        yield f'<section id="{anchor(section.title)}">\n<h2>{escape(section.title)}</h2>\n'
        for block in section.blocks:
            if isinstance(block, Picture):
                yield figure_element(block, next(numbers))
            else:
                yield _html(block, section)
        yield "</section>\n"


def _provenance(document: Document) -> Iterator[Section]:
    generator = document.data.get("generator")
    names = [name for name in document.data.get("files", ()) if name != "report.html"]
    blocks: list[Block] = []
    if generator is not None:
        kernel = f" ({generator['kernel']} kernel)" if "kernel" in generator else ""
        blocks.append(Note(f"Written by {generator['name']} {generator['version']}{kernel}."))
    if names:
        blocks.append(Note(f"Files next to this page, numbers in SI units: {', '.join(names)}."))
    if blocks:
        yield Section("Provenance and files", tuple(blocks))


# -- blocks --------------------------------------------------------------------------------------


@singledispatch
def _html(block: Block, section: Section) -> str:
    raise TypeError(f"cannot format a {type(block).__name__} as HTML")


@_html.register
def _(block: Table, section: Section) -> str:
    table = as_text(block)
    keys, has_head = min(block.keys, len(table.heads) - 1), any(table.labels)
    kinds = [
        "" if place < keys or place in table.words else ' class="number"'
        for place in range(len(table.labels))
    ]
    parts = []
    if block.title and block.title != section.title:
        parts.append(f"<h3>{escape(block.title)}</h3>\n")
    parts.append(f'<div class="wide">\n<table class="{"numbers" if has_head else "study"}">\n')
    if has_head:
        heads = (
            f'<th scope="col"{kind}>{escape(label)}</th>'
            for kind, label in zip(kinds, table.labels, strict=True)
        )
        parts.append(f"<thead><tr>{''.join(heads)}</tr></thead>\n")
    parts.append("<tbody>\n")
    before: str | None = None
    for row in table.rows:
        new = keys > 1 and before not in (None, row[0])
        before = row[0]
        parts.append('<tr class="first">' if new else "<tr>")
        for place, (text, kind) in enumerate(zip(row, kinds, strict=True)):
            # Names in key columns keep their hyphens.
            is_name = place < keys and place in table.words
            parts.append(f"<td{kind}>{escape(text if is_name else signed(text))}</td>")
        parts.append("</tr>\n")
    parts.append("</tbody>\n</table>\n</div>\n")
    if table.left_out:
        rows = "row" if table.left_out == 1 else "rows"
        parts.append(f'<p class="small">{table.left_out} more {rows} in summary.json.</p>\n')
    if block.caption:
        parts.append(f'<p class="small">{escape(block.caption)}</p>\n')
    return "".join(parts)


@_html.register
def _(block: Verdicts, section: Section) -> str:
    judged = judgements(block)
    if not judged:
        return f"<p>{NO_LIMITS}</p>\n"
    remedies = any(judgement.remedy and judgement.word != "ok" for judgement in judged)
    head = ["Verdict", "Judged quantity", "Value", "ok", "Assumption", *(["Remedy"] * remedies)]
    rows = []
    for judgement in judged:
        word = anchor(judgement.word)
        sign = f'<span class="word {word}">{_SIGNS[judgement.word]} {judgement.word}</span>'
        where = f" {escape(judgement.where)}" if judgement.where else ""
        meaning = escape(judgement.meaning)
        if judgement.reason:
            meaning += f'<br><span class="small">{escape(judgement.reason)}</span>'
        remedy = f"<td>{escape(judgement.remedy) if judgement.word != 'ok' else ''}</td>"
        rows.append(
            f"<tr><td>{sign}{where}</td><td>{escape(judgement.name)}</td>"
            f'<td class="whole">{escape(signed(judgement.value))}</td>'
            f'<td class="whole">{escape(judgement.bound)}</td><td>{meaning}</td>'
            f"{remedy if remedies else ''}</tr>\n"
        )
    heads = "".join(f'<th scope="col">{name}</th>' for name in head)
    caption = f'<p class="small">{escape(block.caption)}</p>\n' if block.caption else ""
    return (
        f'<div class="wide">\n<table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n'
        f"{''.join(rows)}</tbody>\n</table>\n</div>\n{caption}"
    )


@_html.register
def _(block: Note, section: Section) -> str:
    kind = ' class="small"' if block.small else ""
    return f"<p{kind}>{escape(block.text)}</p>\n"


@_html.register
def _(block: Items, section: Section) -> str:
    return _list(block.texts)


def _list(texts: list[str] | tuple[str, ...]) -> str:
    return "<ul>\n" + "".join(f"<li>{escape(text)}</li>\n" for text in texts) + "</ul>\n"
