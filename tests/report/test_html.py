"""The page: self-contained, escaped, small, quick, and true to the estimate."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.estimate.results.estimate import Curve, Diagnostic, SegmentRow
from motorid.report import html, segments
from motorid.report.curves import autocorrelation, steepest
from motorid.report.numbers import shown
from motorid.report.plot import Axis, axis, thin
from motorid.segment import segment
from tests.growth import growth
from tests.report.example import estimate, partial
from tests.segment.truth import OPEN, SMALL, drive, record

VOID = {"meta", "link", "br", "path", "rect"}
HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\" onload='x' &amp; $title \u202e"


class Strict(HTMLParser):
    """Checks that tags close in order, and keeps tags, attributes and text."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def parsed(text: str) -> Strict:
    parser = Strict()
    parser.feed(text)
    parser.close()
    assert parser.open == []
    return parser


def test_the_page_is_well_formed_and_loads_nothing() -> None:
    page = parsed(html.render(estimate()))
    assert not {t for t, _ in page.tags} & {"iframe", "img", "object", "embed"}
    for tag, attributes in page.tags:
        for name, value in attributes.items():
            assert not name.startswith("on")
            if name in ("href", "src"):
                assert (tag, value) == ("link", "data:,")
    assert "@import" not in page.text
    assert "url(" not in page.text


def test_no_script_runs_but_the_one_that_the_page_names() -> None:
    page = html.render(estimate(inputs=({"sha256": "", "serial": HOSTILE, "path": HOSTILE},)))
    found = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(found[-1].encode()).digest()).decode()
    assert len(found) == 1
    assert re.findall(r"script-src ([^;]*);", page) == [f"'sha256-{digest}'"]


def test_the_top_names_day_serial_rig_and_file() -> None:
    known = {"created": "2026-01-02T03:04:05+00:00", "serial": "M17", "rig_name": "bench 2"}
    inputs = tuple({**known, "sha256": "", "path": f"/data/run-{k}.h5"} for k in range(6))
    top = parsed(html.render(estimate(inputs=inputs))).text.partition("Parameters")[0]
    for said in ("2026-01-02 03:04 UTC", "M17", "bench 2", "run-0.h5", "and 2 more"):
        assert said in top


def test_the_page_says_what_the_estimate_says() -> None:
    made = estimate()
    text = re.sub(r"[\s\u2007\u2008]+", " ", parsed(html.render(made)).text)
    for p in (*made.parameters.values(), *made.derived.values()):
        assert shown(p).half in text
        assert shown(p).value in text
    for finding in made.diagnostics:
        assert finding.message in text
    for i in made.inputs:
        assert i["sha256"] in text
    assert "Motor M17" in text
    assert made.versions["numpy"] in text


def test_what_is_unknown_is_a_dash_with_its_reason() -> None:
    text = parsed(html.render(partial())).text
    assert "these data do not determine R and L" in text
    assert "R, L: no voltage was measured" in text
    assert "This run only" in text
    assert "nan" not in text.replace("nance", "").lower()
    assert "None" not in text


def test_hostile_metadata_stay_text() -> None:
    made = estimate()
    inputs = tuple(dict(i, serial=HOSTILE, path=f"/x/{HOSTILE}.h5") for i in made.inputs)
    findings = (Diagnostic("x", "error", HOSTILE),)
    six = dict(made.parameters)
    six["R"] = dataclasses.replace(six["R"], note=HOSTILE, unit=HOSTILE)
    curves = tuple(dataclasses.replace(c, channel=HOSTILE, unit=HOSTILE) for c in made.curves)
    page = parsed(
        html.render(
            estimate(
                inputs=inputs, diagnostics=findings, parameters=six, curves=curves,
                options={HOSTILE: HOSTILE}, versions={HOSTILE: HOSTILE}, model=HOSTILE,
                free=(HOSTILE,) * 7,
            )
        )
    )  # fmt: skip
    assert [t for t, _ in page.tags if t in ("script", "img")] == ["script"]
    assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)
    assert "<script>alert(1)</script>" in page.text


@pytest.mark.slow
def test_a_long_run_gives_a_small_page_at_once() -> None:
    """Ten times the readings take less than ten times as long: most of a page is not its curves."""

    def page(n: int) -> str:
        rng = np.random.default_rng(1)
        time_s = np.arange(n) * 1e-4
        wave = np.sin(time_s * 3)
        curves = tuple(
            Curve(k, channel, "A", time_s, wave + 0.01 * rng.standard_normal(n), wave, 0.01)
            for k in range(5)
            for channel in ("current", "position")
        )
        return html.render(estimate(curves=curves))

    assert len(page(50_000).encode()) < 600_000
    assert growth(lambda: page(5_000), lambda: page(50_000)) < 15


@pytest.mark.parametrize(
    "changes",
    [
        {"curves": (), "steady": (), "inputs": (), "free": (), "correlation": np.zeros((0, 0))},
        {"derived": {}, "combinations": {}, "nuisance": {}, "diagnostics": ()},
        {"degrees_of_freedom": 0, "chi_square": float("nan")},
        {"correlation": np.full((7, 7), np.nan)},
    ],
)
def test_less_than_usual_still_makes_a_page(changes: dict[str, object]) -> None:
    parsed(html.render(estimate(**changes)))


def test_missing_readings_and_empty_curves_make_a_page() -> None:
    whole = estimate()
    measured = whole.curves[0].measured.copy()
    measured[100:400] = np.nan
    broken = dataclasses.replace(whole.curves[0], measured=measured)
    flat = Curve(0, "speed", "rad/s", np.arange(3.0), np.zeros(3), np.zeros(3), 0.0)
    empty = Curve(1, "speed", "rad/s", np.zeros(0), np.zeros(0), np.zeros(0), 1.0)
    page = html.render(estimate(curves=(broken, flat, empty)))
    parsed(page)
    assert "nan" not in page.lower()


def test_segments_are_named_over_the_plot_and_judged_in_the_residuals() -> None:
    rows = (SegmentRow(0, "steady", 0.2, 0.35), SegmentRow(0, "coast", 0.95, 1.45))
    text = parsed(html.render(estimate(segments=rows))).text
    assert "residual rms / sigma" in text
    assert "coast" in text


def test_thinning_keeps_every_peak() -> None:
    rng = np.random.default_rng(2)
    y = rng.standard_normal(50_003)
    y[12_345], y[40_000] = 99.0, -99.0
    x = np.arange(len(y), dtype=np.float64)
    a, b = thin(x, y, 300)
    assert len(a) == 600
    assert np.all(np.diff(a) >= 0)
    assert {99.0, -99.0} <= set(b)
    assert np.array_equal(y[a.astype(int)], b)
    assert thin(x[:100], y[:100], 300)[0] is not None


@pytest.mark.parametrize(
    ("low", "high"), [(0, 1), (-3e-7, 2e-7), (1e6, 1.5e6), (5, 5), (0, 0), (-0.12, 7.3)]
)
def test_ticks_are_round_and_inside(low: float, high: float) -> None:
    made = axis((np.array([low, high], dtype=np.float64),))
    ticks = made.ticks()
    assert 2 <= len(ticks) <= 11
    assert all(-1e-9 <= share <= 1 + 1e-9 for share, _ in ticks)
    assert len({label for _, label in ticks}) == len(ticks)


def test_tick_labels_are_exact() -> None:
    labels = [label for _, label in Axis(-0.5, 1.0, 0.25).ticks()]
    assert labels == ["−0.50", "−0.25", "0.00", "0.25", "0.50", "0.75", "1.00"]


def test_autocorrelation_knows_noise_from_memory() -> None:
    rng = np.random.default_rng(3)
    white = rng.standard_normal(20_000)
    slow = np.convolve(white, np.ones(5) / 5, mode="same")
    assert np.abs(autocorrelation([white], 30)[1:]).max() < 0.03
    assert autocorrelation([slow], 30)[:3] == pytest.approx([1.0, 0.8, 0.6], abs=0.03)


def test_close_ups_are_where_the_current_jumps() -> None:
    run = drive(SMALL, [(0.1, 0.0), (0.3, 6.0), (0.2, OPEN)], 10_000)
    windows = steepest(run.current, 3)
    assert any(w.start < run.edges[1] < w.stop for w in windows)
    assert windows == sorted(windows, key=lambda w: w.start)


def test_segments_as_table_and_page() -> None:
    run = drive(SMALL, [(0.1, 0.0), (0.3, 6.0), (0.2, OPEN)], 10_000)
    capture = dataclasses.replace(record(run), path=f"/tmp/{HOSTILE}.h5")
    found = segment(capture)
    lines = segments.table(capture, found).splitlines()
    assert [line.split()[0] for line in lines[1:5]] == ["rest", "acceleration", "steady", "coast"]
    assert "speed, rad/s" in lines[0]
    page = parsed(segments.page(capture, found))
    assert [t for t, _ in page.tags].count("script") == 1
    assert "4 segments over 6000 samples" in page.text


def test_segments_of_nothing_and_of_noise() -> None:
    empty = Capture(np.zeros(0, dtype=np.int64), 1e6, {})
    assert "empty" in segments.table(empty, segment(empty))
    parsed(segments.page(empty, segment(empty)))
    values = np.random.default_rng(1).standard_normal(20)
    values[5:7] = np.nan
    noise = Capture(np.arange(20), 1e3, {"speed": Channel("speed", "rad/s", values)})
    rendered = segments.table(noise, segment(noise))
    assert "speed has no reading" in rendered
    parsed(segments.page(noise, segment(noise)))
