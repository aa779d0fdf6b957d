"""From what on a source has a curve or a head, on few samples written down."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.signals.source import smoothing as module
from motorid.estimate.signals.source.smoothing import ALWAYS, AS_READ, LINE, Form, trend_of
from motorid.estimate.signals.source.step_transient import HEAD

NOISE, SD = 0.04, 0.2


@pytest.mark.parametrize(
    ("count", "mean_square", "half"),
    [
        (64, 1.7, LINE),  # eight means of 8: 64 times that, of which 28 x 4 is noise
        (64, 1.8, 16),  # four times as wide as the part, at most
        (63, 2.1, 8),  # of 7: 56 times that
        (70, 1.8, 16),
        (15, 8.0, AS_READ),  # no window fits
        (16, 20.0, 4),
    ],
)
def test_what_stays_off_its_line_has_the_widest_window_that_fits(
    count: int, mean_square: float, half: int
) -> None:
    """A constant, which every window follows."""
    late = np.full(count, np.sqrt(mean_square))
    assert module._half(late, 4.0, 5.0 if mean_square < 5.0 else 0.5 * mean_square) == half


@pytest.mark.parametrize(("allowed", "half"), [(1.01, LINE), (0.7, AS_READ)])
def test_what_is_quick_but_allowed_has_none(allowed: float, half: int) -> None:
    """A unit by turns, of which the narrowest mean, over nine, leaves (8/9)²."""
    quick = (-1.0) ** np.arange(400)
    assert module._half(quick, 1.0, allowed) == half
    assert module._half(quick + 2.0, 1.0, 1.02) == 64


def test_the_means_of_eight_stretches_are_compared_with_their_noise() -> None:
    assert module._slow(np.ones(8)) == pytest.approx(8.0)
    assert module._slow(np.ones(81)) == pytest.approx(8 * 10.0)
    assert module._slow(np.repeat([1.0, -1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 3.0], 5)) == pytest.approx(
        5.0 * (1 + 1 + 4 + 9)
    )
    assert module._slow(np.ones(7)) == 0.0


@pytest.mark.parametrize("count", [5, 32, 100])
def test_the_head_lies_on_the_line_through_what_follows(count: int) -> None:
    line = 2.0 + 0.5 * np.arange(count)
    line[32:] = 99.0  # too far to tell
    assert module._carried_back(line) == pytest.approx(2.0 + 0.5 * np.arange(-HEAD, 0))


@pytest.mark.parametrize(
    ("place", "times", "head"),
    [(4, 3.6, 5), (4, 3.4, ALWAYS), (1, 3.6, ALWAYS), (7, -3.6, 8), (2, 50.0, ALWAYS)],
)
def test_the_last_sample_that_is_far_off_ends_the_head(place: int, times: float, head: int) -> None:
    odd = np.zeros(HEAD)
    odd[place] = times * SD
    assert module._head(odd, NOISE) == head


@pytest.mark.parametrize(("times", "head"), [(1.9, ALWAYS), (2.1, HEAD)])
def test_samples_that_are_all_somewhat_off_are_all_head(times: float, head: int) -> None:
    """Five of them: 20 of the noise's variance is two and a half times that of eight."""
    odd = np.append(np.zeros(3), np.full(5, times * SD))
    assert module._head(odd, NOISE) == head


@pytest.mark.parametrize(
    ("quick", "declared", "head"),
    [
        (True, 0.0, ALWAYS),  # .1 V beside .2 V of scatter
        (True, 1e-4, HEAD),  # but the channel declares .01 V
        (True, 1.0, ALWAYS),  # more than the readings show
        (False, 1e-4, ALWAYS),  # where a line leaves noise, that is the noise
    ],
)
def test_beside_what_comes_and_goes_the_declared_noise_judges(
    quick: bool, declared: float, head: int
) -> None:
    left = np.append(np.full(HEAD, 0.1), 0.2 * (-1.0) ** np.arange(64))
    trend, form = trend_of(left, NOISE, 0.01 if quick else 1.0, declared)
    assert (form.half == AS_READ) is quick
    assert form.head == head
    assert form.quiet is not quick
    if quick and not declared:
        assert trend_of(left, NOISE, 0.01)[1] == form
        assert trend[HEAD:] == pytest.approx(left[HEAD:])


def test_a_form_has_no_curve_and_no_head_unless_it_is_told() -> None:
    assert Form() == Form(LINE, 0)
    assert Form(AS_READ, 3).quiet is False
    assert Form(4).quiet is True
