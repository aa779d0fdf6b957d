"""Sentences on the scale R = 1 in the words of a log without a current."""

from __future__ import annotations

import pytest

from motorid.estimate.partial.without_current.wording import shown


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("would change J by -0.8%, and", "would change JR/(K²+RB) by -0.8%, and"),
        (
            "would change K by +0.2%, J by +0.9%, and",  # J/K²: .9 − .4
            "would change JR/(K²+RB) by +0.5%, K/(K²+RB) by -0.2%, T0·R/K by -0.2%, and",
        ),
        ("T0 by -1.4%, L by +0.3%.", "T0·R/K by -1.4%, L/R by +0.3%."),
        ("would change J by +0.0%", "would change no combination"),
        ("the speed comes 2 ms late", "the speed comes 2 ms late"),
    ],
)
def test_changes_are_of_combinations(text: str, said: str) -> None:
    assert shown(text, command=False) == said


def test_a_command_stands_where_the_voltage_stood() -> None:
    text = "the motor follows its voltage; the terminal voltage and the voltage's noise"
    assert shown(text, True) == "the motor follows its command; the command and the voltage's noise"
    assert shown(text, False) == text
