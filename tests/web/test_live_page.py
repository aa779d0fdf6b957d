"""The live page in a browser: it loses nothing, and does what a hand asks of it."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire import record
from motorid.acquire.scope import DONE, DRIVING
from motorid.acquire.tap import RunFacts, Scale
from motorid.capture import store
from motorid.program import Decay, Program, Step, StepKind
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel
from tests.acquire.rigs import sim_rig
from tests.chromium import Page, found, opened
from tests.web.served import Served, scope, served

pytestmark = pytest.mark.slow
PERIOD_S = 250e-6
CHANNELS = (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.POSITION)
FACTS = RunFacts(
    1e6,
    250,
    CHANNELS,
    (
        Scale("current", "A", 0.001),
        Scale("terminal_voltage", "V", 0.01),
        Scale("position", "rad", 0.001),
    ),
)
RISE_S = (0.5, 1.0, 1.5)  # of the voltage, from 0 to 6 V; it falls a quarter of a second later
STEP = Program(
    (
        Step(StepKind.COAST, 0.5),
        Step(StepKind.DRIVE_VOLTS, 1.0, 3.0, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.COAST, 1.0),
    )
)
INKS = """[...document.querySelectorAll("canvas")].map((canvas) => {
  const all = [0, 0, canvas.width, canvas.height];
  const data = canvas.getContext("2d").getImageData(...all).data;
  let coloured = 0;
  for (let i = 0; i < data.length; i += 4) {
    const rgb = [data[i], data[i + 1], data[i + 2]];
    if (data[i + 3] > 128 && Math.max(...rgb) - Math.min(...rgb) > 60) coloured++;
  }
  return coloured;
})"""  # coloured pixels of each canvas


@pytest.fixture(scope="module")
def browser() -> Iterator[Callable[[], Page]]:
    with opened(found()) as page:
        yield page


@pytest.fixture
def page(browser: Callable[[], Page]) -> Iterator[Page]:
    one = browser()
    yield one
    one.close()


def feed(here: Served, begin: int = 0, end: int = 8000, leave: tuple[int, int] = (0, 0)) -> None:
    """A square voltage, a current of ± 1 A at 50 Hz, a shaft of 1 rad/s; 4 kHz, two seconds."""
    give = here.tap.begin(FACTS)
    for first in range(begin, end, 100):
        number = np.arange(first, first + 100)
        if leave[0] <= first < leave[1]:
            continue
        seconds = number * PERIOD_S
        volts = np.zeros(100)
        for rise in RISE_S:
            volts[(seconds >= rise) & (seconds < rise + 0.25)] = 600.0
        amps = 1000 * np.sin(2 * np.pi * 50 * seconds)
        counts = np.round(1000 * seconds)
        raw = np.column_stack([amps, volts, counts]).astype(np.int16)
        give(SampleBlock(0, 250 * first, 0, int(counts[0]), CHANNELS, raw))


def figures(page: Page) -> dict[str, Any]:
    found: dict[str, Any] = page.run("motorid.figures")
    return found


def shown(page: Page, here: Served, samples: int) -> None:
    page.open(here.url)
    page.wait(f"globalThis.motorid && motorid.figures.received >= {samples}")
    page.wait("motorid.figures.draws > 0")


def plot(page: Page, channel: str) -> tuple[float, float, float]:
    """Of a channel's plot: left edge, width, and the middle of its height."""
    box = page.run(
        f'(() => {{ const r = document.querySelector("[data-channel={channel}] .u-over")'
        ".getBoundingClientRect(); return [r.left, r.width, r.top + r.height / 2]; })()"
    )
    return box[0], box[1], box[2]


def readout(page: Page) -> dict[str, list[str]]:
    rows = page.run(
        '[...document.querySelectorAll("#readout tr")].map((row) => [...row.cells]'
        ".map((cell) => cell.textContent))"
    )
    return {row[0]: row[1:] for row in rows}


def choose(page: Page, **values: str) -> None:
    for name, value in values.items():
        page.run(f'(() => {{ const e = document.getElementById("{name}"); e.value = "{value}"; '
                 "e.dispatchEvent(new Event('change')); })()")  # fmt: skip


def test_a_run_of_4_khz_loses_no_sample(page: Page, tmp_path: Path) -> None:
    """In real time, on the page and in the capture; its length is that of the short suite."""
    rig = sim_rig(program=STEP, speed="realtime")
    rig = replace(rig, sampling=replace(rig.sampling, rate_hz=4000.0))
    limits = replace(rig.limits, host_silence_s=10.0)  # for a busy computer
    with served(command="capture") as here:
        page.open(here.url)
        page.wait('document.title.includes("bench")')
        record.capture_all(
            replace(rig, limits=limits), STEP, [tmp_path / "run.h5"], watch=here.tap.begin
        )
        kept = store.load(tmp_path / "run.h5")
        page.wait(f"motorid.figures.received >= {len(kept)}")
        seen = figures(page)
    assert (len(kept), kept.gaps) == (10_000, ())
    assert (seen["received"], seen["missing"], seen["lost"]) == (10_000, 0, 0)
    assert page.complaints == []
    page.wait('document.getElementById("state").textContent === "gone"')
    assert figures(page)["received"] == 10_000  # what was seen stays


def test_a_gap_is_counted_and_drawn_as_one(page: Page) -> None:
    with served() as here:
        feed(here, leave=(3000, 3400))
        shown(page, here, 7600)
        assert figures(page)["missing"] == 400
        page.wait('document.getElementById("figures").textContent.includes("400 missing")')


def test_a_hand_zooms_measures_and_follows_again(page: Page) -> None:
    with served() as here:
        feed(here)
        page.size(1280, 800)
        shown(page, here, 8000)
        left, width, y = plot(page, "terminal_voltage")
        begin, end = figures(page)["view"]
        page.drag(left + 0.25 * width, y, left + 0.75 * width)
        page.wait("motorid.figures.held")
        zoomed = figures(page)["view"]
        pixel = (end - begin) / width
        assert zoomed == pytest.approx([begin + 0.5, begin + 1.5], abs=2 * pixel)

        # two clicks: on the plateau that begins at 1.0 s, and between the plateaus
        place = {t: left + width * (t - zoomed[0]) / (zoomed[1] - zoomed[0]) for t in (1.1, 1.35)}
        for x in place.values():
            page.drag(x, y, x)
        page.wait('document.querySelector("#readout thead")?.textContent.includes("RMS")')
        rows = readout(page)
        assert rows["voltage, V"][:3] == ["6.000", "0.0000", "−6.000"]
        assert float(rows["position, rad"][2]) == pytest.approx(0.25, abs=0.01)
        assert float(rows["speed, rad/s"][0]) == pytest.approx(1.0, abs=0.1)
        assert float(rows["current, A"][4]) == pytest.approx(np.sqrt(0.5), abs=0.01)
        note = page.run('document.querySelector("#readout p").textContent')
        (step_ms,) = re.findall(r"Δt = ([\d.]+) ms", note)
        assert float(step_ms) == pytest.approx(250, abs=2e3 * pixel)

        page.mouse("wheel", left + width / 2, y, deltaX=0, deltaY=-100)
        page.wait(f"motorid.figures.view[1] - motorid.figures.view[0] < {0.9 * (end - begin) / 2}")
        page.run('document.getElementById("pause").click()')
        assert not figures(page)["held"]
        feed(here, 8000, 8400)
        page.wait("motorid.figures.received === 8400")
        page.wait("Math.abs(motorid.figures.view[1] - motorid.figures.newest) < 1e-9")
        page.run(
            'document.body.dispatchEvent(new KeyboardEvent("keydown", {key: " ", bubbles: true}))'
        )
        held = figures(page)
        feed(here, 8400, 8800)
        page.wait("motorid.figures.received === 8800")  # a pause holds the view, and loses nothing
        assert (figures(page)["view"], held["held"]) == (held["view"], True)
        assert page.complaints == []


def test_the_plots_stay_where_a_hand_takes_aim(page: Page) -> None:
    """Nothing that the page reads out moves them: no reading, the first ones, one cursor, two."""
    with served() as here:
        feed(here, 0, 8000)
        page.size(1280, 800)
        page.open(here.url)
        page.wait('document.querySelector("[data-channel=current] .u-over") !== null')
        left, width, y = plot(page, "current")
        for heads, click in (("now", 0.3), ("A", 0.6), ("RMS", None)):
            page.wait(f'document.querySelector("#readout thead")?.textContent.includes("{heads}")')
            table, aside = page.run(
                '["#readout table", "#readout"].map((one) =>'
                " document.querySelector(one).getBoundingClientRect().width)"
            )
            assert table <= aside, heads
            assert plot(page, "current") == (left, width, y)
            if click:
                page.drag(left + click * width, y, left + click * width)


def test_a_trigger_stands_by_its_edge(page: Page) -> None:
    with served() as here:
        feed(here, 0, 800)
        shown(page, here, 800)
        choose(page, span="0.1", source="1", level="3", mode="normal")
        feed(here, 800, 4800)  # past the second rise
        page.wait("motorid.figures.shown > 0.9")
        seen = figures(page)
        assert seen["shown"] == pytest.approx(RISE_S[1], abs=PERIOD_S)
        assert seen["view"] == pytest.approx([RISE_S[1] - 0.025, RISE_S[1] + 0.075], abs=PERIOD_S)
        assert not seen["held"]
        choose(page, edge="", mode="single")
        feed(here, 4800, 8000)  # falls at 1.25 and 1.75 s; the first that it sees holds
        page.wait("motorid.figures.held")
        assert figures(page)["shown"] == pytest.approx(1.25, abs=PERIOD_S)


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_seen_in_light_and_dark_wide_and_narrow(scheme: str, width: int, page: Page) -> None:
    with served() as here:
        feed(here)
        page.size(width, 800)
        page.scheme(scheme)
        shown(page, here, 8000)
        page.wait('document.querySelectorAll("canvas").length === 4')
        assert page.run("document.documentElement.scrollWidth") <= width
        page.wait(f"Math.min(...{INKS}) > 100")  # drawn, not only there
        paper, ink = (
            page.run(f"getComputedStyle(document.body).{which}")
            for which in ("backgroundColor", "color")
        )
        dark, light = (sum(map(int, re.findall(r"\d+", one)[:3])) for one in (paper, ink))
        assert (dark < light) == (scheme == "dark")
        assert page.complaints == []


def test_a_press_runs_to_its_end_while_the_page_is_there(page: Page) -> None:
    """Longer than the silence after which it would be stopped."""
    rig, said = sim_rig(program=STEP, speed="realtime"), list[tuple[str, str]]()
    rig = replace(rig, limits=replace(rig.limits, host_silence_s=1.0))
    over = threading.Event()
    with scope(rig, said) as here:
        shown(page, here, 1)
        assert not page.run('document.getElementById("drive").hidden')
        page.run('document.querySelector("[data-do=program]").click()')
        page.wait('document.querySelector("[data-do=program]").disabled')
        page.wait('document.getElementById("said").textContent.includes("the program is over")')
        page.wait('!document.querySelector("[data-do=program]").disabled')
        over.set()
    assert [state for state, _ in said if state in (DRIVING, DONE)] == [DRIVING, DONE]


def test_without_leave_there_is_no_button_that_drives(page: Page) -> None:
    with served() as here:
        feed(here, 0, 400)
        shown(page, here, 400)
        assert page.run('getComputedStyle(document.getElementById("drive")).display') == "none"
