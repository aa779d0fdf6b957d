"""The tutorials' commands end as their pages say, and write what the pictures show."""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from pathlib import Path

import pytest

from tools.site import walk

PAGES = walk.pages()
TUTORIALS = [page for page in PAGES if page.stem.startswith("tutorial-")]  # others take long
LARGEST = 150_000  # bytes of a picture
WORDS = 800  # of a page for a role
OWN_BENCH = re.compile(r"^motorid rigs --show .* > bench\.toml$", re.MULTILINE)
STEP = '[[program.steps]]\\nkind = "drive_volts"\\nvolts = {}\\nduration_s = {}\\n'
LEVELS = "".join(STEP.format(*one) for one in ((6, 0.2), (12, 0.2), (4, 0.3)))
# What makes the bench of a page a quick one: a fifth of the samples for fits of three runs; and no
# coast, which a log does not tell from an open bridge, so that its fit is made twice.
QUICK = {
    "tutorial-bench": "sed -i 's/^rate_hz.*/rate_hz = 2000/' bench.toml",
    "tutorial-data": f"printf '{LEVELS}' >> bench.toml",
}


def test_each_role_has_a_tutorial_and_none_is_long() -> None:
    assert {p.stem for p in TUTORIALS} == {"tutorial-bench", "tutorial-data", "tutorial-line"}
    lengths = {p.stem: len(p.read_text(encoding="utf-8").split()) for p in TUTORIALS}
    assert {name: words for name, words in lengths.items() if words > WORDS} == {}


def walked(page: Path, folder: Path, *more: str) -> None:
    """Every command of the page, and ``more`` after the one that writes a bench's file."""
    for step in walk.steps(page.read_text(encoding="utf-8")):
        if isinstance(step, walk.Commands):
            lines = OWN_BENCH.sub(lambda found: "\n".join([found[0], *more]), step.lines)
            walk.run(replace(step, lines=lines), folder)
        else:
            assert (folder / step.page).is_file(), step


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_page_does_what_it_says(page: Path, tmp_path: Path) -> None:
    """On a quick bench, where the page writes a file of one."""
    walked(page, tmp_path, *filter(None, [QUICK.get(page.stem)]))


@pytest.mark.study
@pytest.mark.parametrize(
    "page", [page for page in TUTORIALS if page.stem in QUICK], ids=lambda page: page.stem
)
def test_it_does_so_on_its_own_bench(page: Path, tmp_path: Path) -> None:
    assert OWN_BENCH.search(page.read_text(encoding="utf-8"))
    walked(page, tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_its_pictures_are_there_small_and_of_their_size(page: Path) -> None:
    for step in walk.steps(page.read_text(encoding="utf-8")):
        if isinstance(step, walk.Picture):
            png = (walk.DOCS / step.image).read_bytes()
            assert struct.unpack(">II", png[16:24]) == (step.width, step.height), step
            assert len(png) < LARGEST, step


def test_a_command_that_ends_otherwise_is_seen(tmp_path: Path) -> None:
    text = "<!-- run -->\n```sh\ntrue\n```\n<!-- run 3 -->\n```sh\necho so\nexit 4\n```\n"
    first, last = walk.steps(text)
    assert walk.Commands("true\n", 0) == first
    assert isinstance(last, walk.Commands)
    with pytest.raises(walk.WalkError, match=r"ended with 4, not 3:\nso"):
        walk.run(last, tmp_path)
