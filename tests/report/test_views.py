"""How estimates and captures show themselves in Python: short, whole, and without a trap."""

from __future__ import annotations

import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture
from motorid.errors import UsageError
from motorid.estimate.results.estimate import Estimate
from motorid.report.numbers import shown
from motorid.report.views import html
from tests.exact_capture import FAULHABER, clean_capture, noisy
from tests.six_parameters import fit

VOID = {"br"}


@pytest.fixture(scope="module")
def capture() -> Capture:
    return noisy(clean_capture(FAULHABER), 1, 1e-3, 1e-4)


@pytest.fixture(scope="module")
def estimate(capture: Capture) -> Estimate:
    return fit([capture])


class Balanced(HTMLParser):
    """Fails on a tag that is not closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


@pytest.mark.slow
def test_a_repr_is_one_short_line(capture: Capture, estimate: Estimate) -> None:
    for one in (capture, estimate):
        assert "\n" not in repr(one)
        assert len(repr(one)) < 250
    assert repr(capture).startswith("<Capture 2,000 samples, 0.2 s: current, position")
    for parameter in estimate.parameters.values():
        view = shown(parameter)
        assert f"{parameter.name} = {view.value} ± {view.half} {view.unit}" in repr(estimate)
    assert "1 capture>" in repr(estimate)


def test_a_serial_number_cannot_leave_its_line(capture: Capture) -> None:
    spoilt = replace(capture, provenance={"serial": "M\n17\x1b[2J<b>"}, end_reason="fault: X")
    assert "\n" not in repr(spoilt)
    assert "\x1b" not in repr(spoilt)
    assert repr(spoilt).endswith("; fault: X>")
    assert "<b>" not in html(spoilt)


@pytest.mark.slow
def test_what_is_not_known_has_no_value(estimate: Estimate) -> None:
    none = replace(estimate.parameters["L"], value=None, total=None, interval_95=None)
    lost = replace(estimate, parameters={**estimate.parameters, "L": none})
    assert "L unknown" in repr(lost)
    assert np.isnan(lost.to_dataframe().loc["L", "value"])
    Balanced(html(lost))


def test_the_page_of_a_notebook_is_whole_and_loads_nothing(
    capture: Capture, estimate: Estimate
) -> None:
    for one in (capture, estimate):
        text = one._repr_html_()
        words = " ".join(Balanced(text).words)
        assert "current" in words
        assert text.count("<svg") == len(capture.channels) if one is capture else "<svg" in text
        assert not [word for word in ("http", "<script", "<style", "src=") if word in text]
        assert len(text) < 100_000
    assert "resistance" in " ".join(Balanced(estimate._repr_html_()).words)


def test_missing_readings_break_a_line_and_are_counted(capture: Capture) -> None:
    channel = capture.channels[CURRENT]
    raw = channel.raw.copy()
    raw[500:900] = np.nan
    holed = replace(capture, channels={CURRENT: replace(channel, raw=raw)})
    text = html(holed)
    assert "nan" not in text.lower()
    assert "400" in Balanced(text).words
    assert text.count("M") > html(capture).count("M") / len(capture.channels)
    nothing = replace(capture, channels={CURRENT: replace(channel, raw=np.full(2000, np.nan))})
    assert "2,000" in Balanced(html(nothing)).words


@pytest.mark.slow
def test_an_empty_capture_shows_itself(capture: Capture) -> None:
    empty = replace(
        capture,
        ticks=capture.ticks[:0],
        channels={n: replace(c, raw=c.raw[:0]) for n, c in capture.channels.items()},
        phases=(),
    )
    assert "0 samples" in repr(empty)
    Balanced(html(empty))
    assert len(empty.to_dataframe()) == 0
    empty.plot()


def test_a_frame_has_the_readings_in_si_units(capture: Capture) -> None:
    frame = capture.to_dataframe()
    assert frame.index.name == "time_s"
    np.testing.assert_array_equal(frame.index, capture.time_s)
    for name, channel in capture.channels.items():
        np.testing.assert_array_equal(frame[name], channel.values)
        assert frame.attrs["units"][name] == channel.unit


def test_a_frame_has_a_row_for_each_quantity(estimate: Estimate) -> None:
    frame = estimate.to_dataframe()
    for name, parameter in estimate.parameters.items():
        row = frame.loc[name]
        assert row["value"] == parameter.value
        assert (row["lower_95"], row["upper_95"]) == parameter.interval_95
        assert row["standard_uncertainty"] == parameter.total
        assert row["unit"] == parameter.unit
    assert set(estimate.derived) <= set(frame.index)


@pytest.mark.slow
def test_a_plot_shows_measured_and_fitted(capture: Capture, estimate: Estimate) -> None:
    drawn = estimate.plot().axes
    assert len(drawn) == len(estimate.curves)
    for axes, curve in zip(drawn, estimate.curves, strict=True):
        measured, fitted = axes.lines
        np.testing.assert_array_equal(measured.get_ydata(), curve.measured)
        np.testing.assert_array_equal(fitted.get_ydata(), curve.fitted)
        assert curve.unit in axes.get_ylabel()
    assert len(capture.plot().axes) == len(capture.channels)


def test_without_matplotlib_a_sentence_says_what_to_install(
    capture: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="pip install matplotlib"):
        capture.plot()
