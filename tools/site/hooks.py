"""What MkDocs needs to build docs/ as it stands: ``mkdocs build`` calls these by name.

The order of the pages is that of docs/index.md: each of its headings is a part of the menu, each
page that is linked below it one line there. Pages of the repository's root (CONTRIBUTING.md and
others) become pages of the site, and links between them and docs/ are turned accordingly.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
FROM_THE_ROOT = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
PART = re.compile(r"^## (.+)$", re.MULTILINE)
PAGE = re.compile(r"\]\((?:\.\./)?([\w-]+\.md)\)")
FENCED = re.compile(r"(^```.*?^```)", re.MULTILINE | re.DOTALL)
ITEM = r"(?:[-*+]|\d+\.) "
# GitHub begins a list or a table right after a line of text or a comment, Python-Markdown does not
LIST_AFTER_TEXT = re.compile(rf"^((?!\s*{ITEM})(?! {{2}})[^\n|#<]*\S)\n(?={ITEM})", re.MULTILINE)
AFTER_A_COMMENT = re.compile(r"^(<!--.*-->)\n(?=\S)", re.MULTILINE)


def slug(heading: str, separator: str) -> str:
    """A heading's anchor, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", separator)


def menu(index: str) -> list[dict[str, list[str]]]:
    """The parts of the menu, each page once, where the index names it first."""
    _, *rest = PART.split(index)
    seen = {"index.md"}
    parts = []
    for title, text in zip(rest[::2], rest[1::2], strict=True):
        pages = [page for page in dict.fromkeys(PAGE.findall(text)) if page not in seen]
        seen.update(pages)
        if pages:
            parts.append({title: pages})
    return parts


def as_python_markdown(page: str) -> str:
    """With the blank lines that Python-Markdown wants, code as it is."""
    pieces = FENCED.split(page)
    for at in range(0, len(pieces), 2):
        pieces[at] = LIST_AFTER_TEXT.sub(r"\1\n\n", AFTER_A_COMMENT.sub(r"\1\n\n", pieces[at]))
    return "".join(pieces)


def on_config(config: Any) -> Any:
    """The menu of the index, and anchors as the repository's links mean them."""
    index = (Path(config["docs_dir"]) / "index.md").read_text(encoding="utf-8")
    config["nav"] = [{"Home": "index.md"}, *menu(index)]
    config["mdx_configs"]["toc"] = {"permalink": False, "slugify": slug}
    return config


def on_files(files: Files, config: Any) -> Files:
    """The root's pages beside those of docs/."""
    for name in FROM_THE_ROOT:
        text = (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "](")
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """A page as Python-Markdown reads it, its links within the site."""
    return as_python_markdown(re.sub(r"\]\(\.\./(?=[\w-]+\.md)", "](", markdown))
