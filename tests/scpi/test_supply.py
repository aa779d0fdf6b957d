"""A supply's protections, level and output, on both sides of what may read back."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.acquire.scpi.dialect import Dialect
from motorid.acquire.scpi.link import Instrument
from motorid.acquire.scpi.supply import Supply
from motorid.errors import LinkError, RigError
from tests.scpi.test_readings import Answers

TABLES: dict[str, dict[str, Any]] = {
    "voltage": {"set": "V {value}", "ask": "V?"},
    "current_limit": {"set": "I {value}", "ask": "I?"},
    "over_voltage": {"set": "OV {value}", "ask": "OV?", "on": "OV ON", "is_on": "OVON?"},
    "over_current": {"on": "OC ON", "is_on": "OCON?"},
    "output": {"on": "ON {channel}", "off": "OFF {channel}", "ask": "ON?"},
}
RIGHT = {"OV?": 9.0, "OVON?": 1, "I?": 3.0, "OCON?": "ON", "ON?": "0", "V?": 6.0}


def supply(more: dict[str, dict[str, Any]] | None = None, **answers: Any) -> tuple[Supply, Answers]:
    tables = TABLES | {name: TABLES.get(name, {}) | table for name, table in (more or {}).items()}
    link = Answers(**(RIGHT | answers))
    told = Dialect("supply", "mine", "", ("HELLO {channel}",), tables)
    return Supply(Instrument("supply", link, ""), told, "2"), link


def test_it_is_selected_and_off_before_anything_else() -> None:
    one, link = supply()
    one.prepare()
    assert link.heard == ["HELLO 2", "OFF 2", "ON?"]


def test_protections_are_set_switched_on_and_read_back() -> None:
    one, link = supply()
    one.protect(9.0, 3.0)
    assert link.heard == ["OV 9.0", "OV?", "OV ON", "OVON?", "I 3.0", "I?", "OC ON", "OCON?"]
    assert one.settings == {"over_voltage": 9.0, "current_limit": 3.0}
    assert one.limit_a == 3.0


def test_a_level_of_over_current_is_set_too_where_there_is_one() -> None:
    one, link = supply({"over_current": {"set": "OC {value}", "ask": "OC?"}}, **{"OC?": 3.0})
    one.protect(9.0, 3.0)
    assert link.heard[-4:] == ["OC 3.0", "OC?", "OC ON", "OCON?"]
    assert one.settings["over_current"] == 3.0


def test_a_limit_that_protects_needs_no_other() -> None:
    one, link = supply({"current_limit": {"protects": True}})
    one.protect(9.0, 3.0)
    assert link.heard[-1] == "I?"


def test_a_protection_without_a_switch_is_on_by_its_level() -> None:
    one, link = supply({"over_voltage": {"on": ""}})
    one.protect(9.0, 3.0)
    assert "OVON?" not in link.heard


@pytest.mark.parametrize(
    ("asked", "volts", "good"),
    [
        (9.0, 9.08, True),  # a hundredth above at most
        (9.0, 9.10, False),
        (9.0, 8.11, True),  # a tenth below
        (9.0, 8.09, False),
        (1.0, 1.019, True),  # or a step of a coarse setting
        (1.0, 1.021, False),
    ],
)
def test_what_a_voltage_s_protection_may_read_back(asked: float, volts: float, good: bool) -> None:
    one, _ = supply(**{"OV?": volts})
    if good:
        one.protect(asked, 3.0)
    else:
        with pytest.raises(RigError, match=rf"over-voltage was set to {asked:g} V and reads back"):
            one.protect(asked, 3.0)


@pytest.mark.parametrize(
    ("asked", "amperes", "good"), [(0.1, 0.1049, True), (0.1, 0.1051, False), (3.0, 3.02, True)]
)
def test_what_a_current_limit_may_read_back(asked: float, amperes: float, good: bool) -> None:
    one, _ = supply(**{"I?": amperes})
    if good:
        one.protect(9.0, asked)
    else:
        with pytest.raises(RigError, match="current-limit was set to"):
            one.protect(9.0, asked)


@pytest.mark.parametrize("answer", ["0", "OFF", "maybe"])
@pytest.mark.parametrize("ask", ["OVON?", "OCON?"])
def test_a_protection_that_stays_off_is_said(ask: str, answer: str) -> None:
    one, _ = supply(**{ask: answer})
    with pytest.raises(RigError, match="protection was switched on and reads back"):
        one.protect(9.0, 3.0)


def test_a_protection_that_has_tripped_is_said() -> None:
    one, _ = supply({"over_current": {"tripped": "OCT?"}}, **{"OCT?": "1"})
    with pytest.raises(RigError, match="the supply's over-current protection has tripped already"):
        one.protect(9.0, 3.0)
    assert supply({"over_current": {"tripped": "OCT?"}}, **{"OCT?": "0"})[0].tripped() == ""
    unclear = supply({"over_voltage": {"tripped": "OVT?"}}, **{"OVT?": "odd"})[0]
    assert unclear.tripped() == "over-voltage"


@pytest.mark.parametrize(
    ("asked", "found", "good"),
    [(6.0, 6.05, True), (6.0, 6.07, False), (6.0, 5.95, True), (6.0, 5.93, False),
     (-6.0, -6.05, True), (-6.0, 6.0, False), (0.1, 0.119, True), (0.1, 0.121, False)],
)  # fmt: skip
def test_a_level_reads_back_within_a_hundredth(asked: float, found: float, good: bool) -> None:
    one, link = supply(**{"V?": found})
    if good:
        one.set(asked)
        assert link.heard == [f"V {asked}", "V?"]
    else:
        with pytest.raises(RigError, match=f"set to {asked:g} V and reads back {found:g} V"):
            one.set(asked)


def test_an_output_is_switched_and_seen_to_be() -> None:
    one, link = supply(**{"ON?": ["1"]})
    one.on()
    assert link.heard == ["ON 2", "ON?"]
    with pytest.raises(RigError, match="switched on and reads back off"):
        supply()[0].on()
    with pytest.raises(LinkError, match="of its output 'odd', neither on nor off"):
        supply(**{"ON?": "odd"})[0].is_on()


@pytest.mark.parametrize(
    ("answers", "tries"), [(["0"], 1), (["1", "0"], 2), (["1", "odd", "0"], 3)]
)
def test_an_output_is_told_three_times_to_go_off(answers: list[str], tries: int) -> None:
    one, link = supply(**{"ON?": answers})
    one.off()
    assert link.heard.count("OFF 2") == tries


def test_an_output_that_stays_on_is_said_loudly() -> None:
    one, link = supply(**{"ON?": "1"})
    with pytest.raises(
        LinkError, match=r"MAY STILL BE ON: .* told to 3 times \(it reads back on\)"
    ):
        one.off()
    assert link.heard.count("OFF 2") == 3


@pytest.mark.parametrize(
    ("facts", "answer", "limited"),
    [
        ({}, "", False),
        ({"ask": "L?"}, "1", True),
        ({"ask": "L?"}, "2", False),
        ({"ask": "L?", "mask": 2}, "3", True),
        ({"ask": "L?", "mask": 2}, "+5.0", False),
        ({"ask": "L?", "word": "cc"}, "mode CC", True),
        ({"ask": "L?", "word": "cc"}, "CV", False),
    ],
)
def test_whether_the_current_is_limited(facts: dict[str, Any], answer: str, limited: bool) -> None:
    assert supply({"limiting": facts}, **{"L?": answer})[0].limited() is limited


def test_a_register_that_is_no_number_is_said() -> None:
    with pytest.raises(LinkError, match=r"answers 'L\?' with 'odd'"):
        supply({"limiting": {"ask": "L?"}}, **{"L?": "odd"})[0].limited()


@pytest.mark.parametrize(
    ("section", "key"), [("over_voltage", "ask"), ("over_voltage", "set"), ("over_current", "on")]
)
def test_a_dialect_without_a_protection_switches_nothing_on(section: str, key: str) -> None:
    one, _ = supply({section: {key: ""} | ({"on": ""} if key == "set" else {})})
    with pytest.raises(RigError, match=rf"the dialect mine has no {section}\.{key}"):
        one.protect(9.0, 3.0)


def test_its_own_readings_and_its_link() -> None:
    one, link = supply({"measure": {"current": "M{channel}?"}})
    assert one.measure_query("current") == "M2?"
    assert one.measure_query("terminal_voltage") == ""
    one.close()
    assert link.heard == ["closed"]
