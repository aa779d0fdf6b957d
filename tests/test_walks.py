"""The tutorials' commands end as their pages say, and write what the pictures show."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import pytest

from tools.site import walk

PAGES = walk.pages()
TUTORIALS = [page for page in PAGES if page.stem.startswith("tutorial-")]  # others take long
LARGEST = 150_000  # bytes of a picture
WORDS = 800  # of a page for a role
BENCH = "motorid rigs --show sim > bench.toml"
SLOW_BENCH = f"{BENCH}\nsed -i 's/^rate_hz.*/rate_hz = 2000/' bench.toml"


def test_each_role_has_a_tutorial_and_none_is_long() -> None:
    assert {p.stem for p in TUTORIALS} == {"tutorial-bench", "tutorial-data", "tutorial-line"}
    lengths = {p.stem: len(p.read_text(encoding="utf-8").split()) for p in TUTORIALS}
    assert {name: words for name, words in lengths.items() if words > WORDS} == {}


def walked(page: Path, folder: Path, bench: str = BENCH) -> None:
    """Every command of the page, on that bench."""
    for step in walk.steps(page.read_text(encoding="utf-8")):
        if isinstance(step, walk.Commands):
            walk.run(replace(step, lines=step.lines.replace(BENCH, bench)), folder)
        else:
            assert (folder / step.page).is_file(), step


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_page_does_what_it_says(page: Path, tmp_path: Path) -> None:
    """The simulated bench with a fifth of its samples, which three fits take half as long for."""
    walked(page, tmp_path, SLOW_BENCH)


@pytest.mark.study
def test_the_bench_does_so_at_its_own_rate(tmp_path: Path) -> None:
    (page,) = (page for page in TUTORIALS if BENCH in page.read_text(encoding="utf-8"))
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
