"""The page that holds a report: one file, nothing loaded from elsewhere, whole without its script.

The script is the only one that the page's own rule lets a browser run: the rule names its digest.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from string import Template

from motorid.visible import visible


@dataclass(frozen=True)
class Link:
    """A cell of a table that leads somewhere, or that holds a small picture as well."""

    text: str
    target: str = ""
    picture: str = ""  # HTML

    @property
    def html(self) -> str:
        """What stands in the cell."""
        said = escape(self.text)
        return (
            f'<a href="{escape(self.target)}">{said}</a>' if self.target else said
        ) + self.picture


def page(title: str, body: Iterable[str]) -> str:
    """A whole HTML document. ``title`` is plain text; ``body`` is HTML."""
    here = resources.files("motorid.report")
    template = Template(here.joinpath("page.html").read_text("utf-8"))
    style = here.joinpath("report.css").read_text("utf-8")
    script = here.joinpath("report.js").read_text("utf-8")
    whole = template.substitute(
        title=escape(title),
        style=style,
        body="\n".join(body),
        script=script,
        digest=_digest(script),
    )
    return visible(whole)


def policy() -> str:
    """The page's own rule, as a server says it in a header."""
    script = resources.files("motorid.report").joinpath("report.js").read_text("utf-8")
    return (
        f"default-src 'none'; style-src 'unsafe-inline'; script-src '{_digest(script)}'; "
        "img-src data:"
    )


def _digest(script: str) -> str:
    """As a content security policy names it."""
    return f"sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}"


def section(title: str, *parts: str, more: bool = False) -> str:
    """A heading and what belongs to it; nothing where there is nothing.

    ``more``: it is left out on paper, where the page is a summary.
    """
    inside = "\n".join(p for p in parts if p)
    kind = ' class="more"' if more else ""
    return f"<section{kind}>\n<h2>{escape(title)}</h2>\n{inside}\n</section>" if inside else ""


def figure(caption: str, *parts: str, aside: str = "") -> str:
    """A figure with its caption."""
    more = f' <span class="soft">{escape(aside)}</span>' if aside else ""
    return f"<figure><figcaption>{escape(caption)}{more}</figcaption>{''.join(parts)}</figure>"


def table(head: Sequence[str], rows: Iterable[Sequence[str | Link]], kind: str = "") -> str:
    """A table of plain text and links; columns after the first are numbers, set to the right, and
    one without a heading holds words.
    """
    kinds = [_of_column(k, name) for k, name in enumerate(head)]
    top = "".join(f"<th{of}>{escape(name)}</th>" for of, name in zip(kinds, head, strict=True))
    lines = "".join(
        "<tr>"
        + "".join(f"<td{of}>{_cell(c)}</td>" for of, c in zip(kinds, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr>{top}</tr></thead>'
        f"<tbody>{lines}</tbody></table></div>"
    )


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph of plain text; nothing for no text."""
    return f'<p class="{kind}">{escape(text)}</p>' if text else ""


def _cell(cell: str | Link) -> str:
    return cell.html if isinstance(cell, Link) else escape(cell)


def _of_column(place: int, heading: str) -> str:
    if not place:
        return ""
    return ' class="num"' if heading else ' class="wrap"'
