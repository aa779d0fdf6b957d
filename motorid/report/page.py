"""The page that holds a report: one file, nothing loaded from elsewhere, no script."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from string import Template

from motorid.visible import visible


def page(title: str, body: Iterable[str]) -> str:
    """A whole HTML document. ``title`` is plain text; ``body`` is HTML."""
    here = resources.files("motorid.report")
    template = Template(here.joinpath("page.html").read_text("utf-8"))
    style = here.joinpath("report.css").read_text("utf-8")
    whole = template.substitute(title=escape(title), style=style, body="\n".join(body))
    return visible(whole)


def section(title: str, *parts: str) -> str:
    """A heading and what belongs to it; nothing where there is nothing."""
    inside = "\n".join(p for p in parts if p)
    return f"<section>\n<h2>{escape(title)}</h2>\n{inside}\n</section>" if inside else ""


def figure(caption: str, *parts: str, aside: str = "") -> str:
    """A figure with its caption."""
    more = f' <span class="soft">{escape(aside)}</span>' if aside else ""
    return f"<figure><figcaption>{escape(caption)}{more}</figcaption>{''.join(parts)}</figure>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """A table of plain text; columns after the first are numbers, set to the right."""
    top = "".join(f"<th{_number(k)}>{escape(cell)}</th>" for k, cell in enumerate(head))
    lines = "".join(
        "<tr>" + "".join(f"<td{_number(k)}>{escape(c)}</td>" for k, c in enumerate(row)) + "</tr>"
        for row in rows
    )
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr>{top}</tr></thead>'
        f"<tbody>{lines}</tbody></table></div>"
    )


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph of plain text; nothing for no text."""
    return f'<p class="{kind}">{escape(text)}</p>' if text else ""


def _number(column: int) -> str:
    return ' class="num"' if column else ""
