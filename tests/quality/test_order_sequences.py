"""Drawn scans and orders: each verdict has its own order, and each order its verdict."""

from __future__ import annotations

import random
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.quality.product import Product
from motorid.quality.verdict import Verdict
from motorid.report.screen import Screen
from motorid.workflow.check import Inspection, Who
from motorid.workflow.station import Station

ROUNDS = 1_000  # of about ten scans and orders each
SERIALS = ["D000001", "D000002", "D000003", "none", ""]


class Bench:
    """A line without a board; ``while_it_turns`` is called in the middle of each inspection."""

    rig = SimpleNamespace(name="none")
    who = Who()

    def __init__(self, product: Product, folder: Path) -> None:
        self.product, self.folder = product, folder
        self.inspected: list[str] = []
        self.while_it_turns = lambda: None

    def warm(self) -> None:
        pass

    def inspect(self, serial: str, *, retest: str = "") -> Inspection:
        self.while_it_turns()
        self.inspected.append(serial)
        return Inspection(Verdict("none", serial, ()), self.folder, 4, {})


class People:
    """Who scans and who orders, and what they were told."""

    def __init__(self, station: Station, rng: random.Random) -> None:
        self.station, self.rng = station, rng
        self.accepted: list[str] = []  # by an order, in their turn
        self.judged: list[str] = []
        self.scanned: list[str] = []  # taken into work

    def act(self) -> None:
        serial = self.rng.choice(SERIALS)
        if self.rng.random() < 0.5:
            before = self.station.kept.waiting()
            self.station.scan([serial], ends=False)
            self.scanned += [one for one in self.station.kept.waiting() if one not in before]
        else:
            self.station.take({"order": "inspect", "serial": serial}, self.hear)

    def hear(self, answer: dict[str, Any]) -> None:
        if answer["event"] == "accepted":
            self.accepted.append(answer["serial"])
        if answer["event"] == "verdict":
            self.judged.append(answer["serial"])


@pytest.mark.slow
def test_no_verdict_without_an_order_after_the_last_and_none_lost(
    product: Product, tmp_path: Path
) -> None:
    rng = random.Random(20)
    bench = Bench(product, tmp_path)
    line: Any = bench
    taken = 0
    station = Station(line, lambda screen: None)
    people = People(station, rng)
    for _ in range(ROUNDS):
        told: list[int] = []

        def crowd(told: list[int] = told) -> None:
            before = len(people.accepted) + len(people.scanned)
            for _ in range(rng.randint(0, 5)):
                people.act()
            told.append(len(people.accepted) + len(people.scanned) - before)

        bench.while_it_turns = crowd
        for _ in range(rng.randint(0, 12)):
            people.act()
        now = len(people.accepted) + len(people.scanned)
        assert now - taken <= 1  # of all that were scanned and ordered before a verdict
        station.end()
        station.run()
        assert told == [0] * (now - taken)  # none while a motor turns
        taken = now
        assert len(bench.inspected) == taken
        assert station.kept.waiting() == ()
    assert people.judged == people.accepted
    assert sorted(bench.inspected) == sorted(people.accepted + people.scanned)
    assert min(len(people.accepted), len(people.scanned)) > ROUNDS // 4


def test_an_order_that_comes_while_the_station_begins_is_none_of_an_earlier_shift(
    product: Product, tmp_path: Path
) -> None:
    line: Any = Bench(product, tmp_path)
    shown: list[Screen] = []
    Station(line, shown.append).scan(["D000001"], ends=False)  # killed before its verdict
    station = Station(line, shown.append)
    station.scan(["D000002"], ends=True)
    station.run()
    assert "never judged: D000001." in shown[0].lines[-1]
    assert line.inspected == ["D000002"]
