"""The site of docs/: every page, its menu and its search, without a network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tools.site import hooks

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
LOADED = re.compile(
    r"<(?:script|img|iframe|source)\b[^>]*\bsrc=\"([^\"]+)\"|<link\b[^>]*\bhref=\"([^\"]+)\""
)
IN_A_STYLE = re.compile(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("built") / "site"
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT, env=dict(os.environ), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.mark.slow
def test_it_has_every_page_and_finds_their_words(site: Path) -> None:
    pages = {page.stem for page in DOCS.glob("*.md")}
    assert pages <= {page.stem for page in site.glob("*.html")}
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    found = {entry["location"].partition(".html")[0] for entry in index["docs"] if entry["text"]}
    assert pages - {"index"} <= found


@pytest.mark.slow
def test_nothing_of_it_is_loaded_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        loaded = [a or b for a, b in LOADED.findall(page.read_text(encoding="utf-8"))]
        assert loaded
        assert [url for url in loaded if url.startswith(("http:", "https:", "//"))] == [], page
    for style in site.rglob("*.css"):
        assert not IN_A_STYLE.search(style.read_text(encoding="utf-8")), style


def test_the_menu_is_that_of_the_index() -> None:
    first = "# Title\n[early](z.md)\n## First\n[a](a.md) [r](../R.md)\n"
    rest = "## None\n## Last\n[a](a.md#b) [b](b.md) [a](a.md)\n"
    assert hooks.menu(first + rest) == [{"First": ["a.md", "R.md"]}, {"Last": ["b.md"]}]
    parts = hooks.menu((DOCS / "index.md").read_text(encoding="utf-8"))
    pages = [page for part in parts for named in part.values() for page in named]
    assert len(pages) == len(set(pages))
    assert {page.name for page in DOCS.glob("*.md")} - {"index.md"} <= set(pages)


def test_lists_and_tables_begin_where_github_begins_them() -> None:
    page = "text:\n- one\n  more\n- two\n\n<!-- a -->\n| t |\n\n```\ncode\n- code\n```\n"
    wanted = "text:\n\n- one\n  more\n- two\n\n<!-- a -->\n\n| t |\n\n```\ncode\n- code\n```\n"
    assert hooks.as_python_markdown(page) == wanted


def test_an_anchor_is_that_of_the_repository() -> None:
    assert hooks.slug("R&R, and a `golden` motor", "-") == "rr-and-a-golden-motor"
