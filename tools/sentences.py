"""How long the sentences of the documents are: those over a limit, and the median of each page.

Code, tables and headings are left out. It ends with 1 where too many of all sentences are long, or
where a page's median is too high. ``--list`` prints the long sentences; pages may be named.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parent.parent
LONGEST = 30  # words
LONG_SHARE = 0.05  # of the sentences of all pages named
HIGHEST_MEDIAN = 18  # words, of each page
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
ITEM = re.compile(r"^\s*(?:[-*+]|\d+\.)\s+")
# code, a link's target and emphasis say nothing of how long a sentence is
MARKS = ((re.compile(r"`[^`]*`"), "Code"), (re.compile(r"\]\([^)]*\)"), "]"))
END = re.compile(r"(?<=[.!?])[\])\"*]*\s+(?=[\[(\"*]*[A-Z0-9])")
WORD = re.compile(r"[^\W_]")


def paragraphs(page: str) -> Iterator[str]:
    """Running text, an item of a list being a paragraph of its own."""
    lines: list[str] = []
    for line in [*COMMENT.sub("", FENCED.sub("", page)).splitlines(), ""]:
        is_text = line.strip() and not line.lstrip().startswith(("|", "#", "!["))
        indented = line.startswith("    ") and not lines and not ITEM.match(line)
        if lines and (not is_text or ITEM.match(line)):
            yield " ".join(lines)
            lines = []
        if is_text and not indented:
            lines.append(ITEM.sub("", line).strip())


def sentences(page: str) -> Iterator[str]:
    """Every sentence of a page, its code and its links as one word each."""
    for paragraph in paragraphs(page):
        for pattern, word in MARKS:
            paragraph = pattern.sub(word, paragraph)
        yield from filter(WORD.search, END.split(paragraph))


def words(sentence: str) -> int:
    """Signs alone, such as a dash, count for nothing."""
    return sum(bool(WORD.search(word)) for word in sentence.split())


def faults(lengths: dict[str, list[int]]) -> Iterator[str]:
    """A sentence for each bound that the pages pass; ``lengths`` in words, by page."""
    every = [length for found in lengths.values() for length in found]
    long = sum(length > LONGEST for length in every)
    if long > LONG_SHARE * len(every):
        share = f"{long} of {len(every)} sentences have more than {LONGEST} words"
        yield f"{share}, which is above {LONG_SHARE:.0%}: --list shows them"
    for page, found in lengths.items():
        if found and median(found) > HIGHEST_MEDIAN:
            yield f"{page}: the median is {median(found):.0f} words, above {HIGHEST_MEDIAN}"


def main(arguments: list[str]) -> int:
    """A line for every page; exit code 1 where a bound is passed."""
    listed = "--list" in arguments
    named = [Path(name) for name in arguments if not name.startswith("--")]
    pages = named or [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]
    print(f"{'page':24} {'sentences':>9} {'over ' + str(LONGEST):>8} {'median':>7}")
    lengths: dict[str, list[int]] = {}
    for page in pages:
        found = list(sentences(page.read_text(encoding="utf-8")))
        counted = lengths[page.name] = [words(sentence) for sentence in found]
        long = sum(length > LONGEST for length in counted)
        middle = median(counted) if counted else 0
        print(f"{page.name:24} {len(found):9} {long:8} {middle:7.0f}")
        if listed:
            for sentence, length in zip(found, counted, strict=True):
                if length > LONGEST:
                    print(f"    {length}: {sentence}")
    passed = list(faults(lengths))
    for fault in passed:
        print(fault, file=sys.stderr)
    return 1 if passed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
