"""Documents that hold together: links resolve, and every command in them is one that exists."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from motorid.cli.main import COMMANDS, cli
from motorid.estimate.effects.registry import BY_NAME, REGISTRY
from tools import glossary_page, influence_page, sentences

ROOT = Path(__file__).resolve().parent.parent
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]
FOLDERS = ("motorid", "firmware", "tools", "tests", "bench")
FILES = [
    path.relative_to(ROOT).as_posix() for name in FOLDERS for path in (ROOT / name).rglob("*.py")
]
MODULE = re.compile(r"`([\w/.-]+\.py)\b")
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
INTO = re.compile(r"\]\(([^)#:]*\.md|)#([^)]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
BLOCK = re.compile(r"^```[\s\S]*?^```|^(?: {4}.*\n)+", re.MULTILINE)
IN_A_BLOCK = re.compile(r"^\s*(?:\$ )?(motorid [a-z].*)$", re.MULTILINE)
IN_A_SENTENCE = re.compile(rf"`(motorid (?:{'|'.join(COMMANDS)})\b[^`]*)`")

FOR_ROLES = (
    "Begin",
    "Measure a motor",
    "Fit logs and captures",
    "Inspect motors",
    "When something is wrong",
    "Build a rig",
)
LOOKED_UP = {  # among them: read line by line, where one needs it
    *("rig-file.md", "board-pins.md", "calibration-file.md", "product-file.md"),
    *("import.md", "report.md", "file-format.md"),
    *("facts.md", "suspects.md", "mistakes.md", "wider-models.md"),
    *("firmware.md", "porting.md", "protocol.md", "emulated-rig.md", "simulator.md"),
}
MOST_WORDS = 800  # of a page that a role reads from top to bottom


def by_name(page: Path) -> str:
    return page.name


def commands(text: str) -> Iterator[str]:
    """The command lines of a page, in blocks and in running text, comments cut off."""
    text = re.sub(r"\\\n\s*", "", text)
    found = [line for block in BLOCK.findall(text) for line in IN_A_BLOCK.findall(block)]
    for line in found + IN_A_SENTENCE.findall(BLOCK.sub("", text)):
        yield line.partition("  #")[0].replace("\n", " ").strip()


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_links_resolve(page: Path) -> None:
    links = LINK.findall(page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_links_into_a_page_meet_a_heading(page: Path) -> None:
    for name, heading in INTO.findall(page.read_text(encoding="utf-8")):
        target = (page.parent / name if name else page).read_text(encoding="utf-8")
        slugs = [
            re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
            for words in HEADING.findall(target)
        ]
        assert heading in slugs, f"{name}#{heading}"


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_modules_that_a_page_names_exist(page: Path) -> None:
    """By their paths, or the ends of them; CHANGELOG names what was."""
    if page.name == "CHANGELOG.md":
        return
    text = re.sub(r"^<!-- file:.*", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    named = set(MODULE.findall(BLOCK.sub("", text)))
    assert {
        name for name in named if not any(f"/{file}".endswith(f"/{name}") for file in FILES)
    } == set()


def test_index_lists_every_document() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"index.md"}
    assert {name for name in pages if f"]({name})" not in index} == set()


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_commands_in_documents_parse(page: Path) -> None:
    for line in commands(page.read_text(encoding="utf-8")):
        name, *words = shlex.split(line)[1:]
        command = cli.get_command(click.Context(cli), name)
        assert command is not None, line
        if words and not {"--help", "…", "..."} & set(words):
            parse(command, words, line)


def test_every_influence_quantity_has_its_row_as_declared() -> None:
    assert influence_page.PAGE.read_text(encoding="utf-8") == influence_page.page()
    rows = influence_page.table().splitlines()[2:]
    assert [line.split(" | ")[0].removeprefix("| ") for line in rows] == list(BY_NAME)
    assert [quantity.name for quantity in REGISTRY if not quantity.remedy] == []


def test_the_glossary_has_the_names_of_the_code() -> None:
    text = glossary_page.PAGE.read_text(encoding="utf-8")
    assert glossary_page.page(text) == text
    assert "| `K` | torque constant | N·m/A | `torque_constant_nm_a` |" in text
    assert glossary_page.page(text.replace("torque_constant_nm_a", "k_nm_a")) == text


def test_pages_of_a_role_are_short() -> None:
    """Code blocks are not counted; tables are."""
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    of_roles = [part for part in index.split("\n## ") if part.startswith(FOR_ROLES)]
    pages = set(re.findall(r"\(([a-z-]+\.md)\)", "".join(of_roles))) - LOOKED_UP
    assert len(of_roles) == len(FOR_ROLES)
    for page in sorted(pages):
        text = (ROOT / "docs" / page).read_text(encoding="utf-8")
        assert len(sentences.FENCED.sub("", text).split()) <= MOST_WORDS, page


def test_what_a_symptom_points_to_exists() -> None:
    """Keys of the rig file, codes of findings and options are those of the pages that list them."""
    symptoms = ("symptoms.md", "symptoms-runs.md")
    page = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in symptoms)
    named = {
        word
        for code in re.findall(r"`([^`]+)`", page)
        for word in re.findall(r"--[a-z-]+|[a-z]+(?:_[a-z0-9]+)+", code)
    }
    listing = ("rig-file.md", "facts.md", "suspects.md", "commands.md", "report.md")
    listed = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in listing)
    assert len(named) > 20
    assert {word for word in named if word not in listed} == set()


def test_sentences_are_those_of_running_text() -> None:
    page = """# A heading of words that count for nothing

One two three. Four `x = 1. Y = 2` [five six](seven.md "8")!

| a table | of words |

```
code that is no sentence.
```

    nor is this. Or this.

- An item of
  two lines
- and one more; 0.5 of it.
"""
    found = list(sentences.sentences(page))
    assert [sentences.words(sentence) for sentence in found] == [3, 4, 5, 6]


def test_too_many_long_sentences_are_seen(tmp_path: Path) -> None:
    assert list(sentences.faults({"a.md": [10] * 95 + [31] * 5, "b.md": []})) == []
    share, middle = sentences.faults({"a.md": [10] * 94, "b.md": [31] * 6})
    assert "6 of 100 sentences have more than 30 words" in share
    assert middle.startswith("b.md: the median is 31")
    page = tmp_path / "page.md"
    page.write_text(" ".join(["word"] * 19) + ".", encoding="utf-8")
    assert sentences.main([str(page)]) == 1
    page.write_text(" ".join(["word"] * 18) + ".", encoding="utf-8")
    assert sentences.main([str(page)]) == 0


def parse(command: click.Command, words: list[str], line: str) -> None:
    """Parses options and arguments as the command would, without running or asking for files."""
    try:
        command.make_parser(click.Context(command)).parse_args(words)
    except click.UsageError as error:
        raise AssertionError(f"{line}: {error.format_message()}") from error


def test_the_command_finder_finds_them() -> None:
    text = """motorid is a tool. Run

    motorid run --rig sim \\
        -o out   # comment

or `motorid fit
a.h5`, as in

```
$ motorid segment a.h5
```
"""
    assert list(commands(text)) == [
        "motorid run --rig sim -o out",
        "motorid segment a.h5",
        "motorid fit a.h5",
    ]
