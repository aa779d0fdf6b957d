"""What the operator's page shows beside the word: the last motors, the yield, the golden motor."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

from motorid import json_seal
from motorid.errors import DataError
from motorid.quality.product import Product
from motorid.report.screen import Screen
from motorid.workflow.check import VERDICT, Inspection
from motorid.workflow.shift_folder import newest_first
from motorid.workflow.station import Station
from motorid.workflow.station_words import OUTCOMES

LAST = 10


class ShiftBoard:
    """Keeps the last motors and how long ago the rig was shown to be sound.

    Both go on from what is on disk under ``folder``. They are of one product.
    """

    def __init__(self, folder: Path, product: Product) -> None:
        self.product = product
        self.last: deque[dict[str, Any]] = deque(maxlen=LAST)  # the newest first
        self.since_sound = product.self_test.inspections  # until a motor passes, it is due
        newest = max(LAST, product.self_test.inspections)
        for stored in reversed(_stored(folder, product, newest)):
            self._note(stored["serial"], stored["outcome"], stored["time"])

    def judged(self, done: Inspection) -> None:
        """One more motor."""
        verdict = done.verdict
        self._note(verdict.serial, str(verdict.outcome), _time(done))

    def _note(self, serial: str, outcome: str, time: str) -> None:
        self.last.appendleft({"serial": serial, "outcome": outcome, "time": time})
        golden = self.product.self_test.golden
        sound = outcome == "PASS" and (not golden or serial in golden)
        self.since_sound = 0 if sound else self.since_sound + 1

    def facts(self, screen: Screen, station: Station) -> dict[str, Any]:
        """All that a page shows, as plain data."""
        test, first = self.product.self_test, station.first
        judged = first["PASS"] + first["FAIL"]
        serial, lines = self._named(screen)
        return {
            "word": screen.word,
            "serial": serial,
            "lines": lines,
            "next": screen.next_step,
            "counts": {name: station.counts[name] for name in OUTCOMES},
            "first_pass_yield": first["PASS"] / judged if judged else None,
            "first_tests": judged,
            "again": sum(station.counts.values()) - sum(first.values()),
            "ignored": station.ignored,
            "last": list(self.last),
            "golden": list(test.golden),
            "golden_due": max(test.inspections - self.since_sound, 0),
        }

    def _named(self, screen: Screen) -> tuple[str, list[str]]:
        """The serial number, which a page shows large, and the other lines."""
        first, *others = screen.lines or ("",)
        match screen.word:
            case "READY":
                return "", others if first == self.product.title else [first, *others]
            case "RUN":
                return first, others
        serial = self.last[0]["serial"] if self.last else ""
        return (serial, others) if serial and serial in first else (first, others)


def _time(done: Inspection) -> str:
    """When a motor was judged, as its file says; "" where it cannot be read."""
    if done.folder is None:
        return ""
    try:
        return str(json_seal.read(done.folder / VERDICT, "a verdict").get("time", ""))
    except DataError:
        return ""


def _stored(folder: Path, product: Product, most: int) -> list[dict[str, str]]:
    """Verdicts under ``folder`` by this very product, the newest first."""
    found: list[dict[str, str]] = []
    for one in newest_first(folder):
        try:
            stored = json_seal.read(one / VERDICT, "a verdict")
        except DataError:
            continue  # not judged, or damaged: it proves nothing
        versions = stored.get("versions")
        if isinstance(versions, dict) and versions.get("product") == product.digest:
            found.append({key: str(stored.get(key, "")) for key in ("serial", "outcome", "time")})
        if len(found) >= most:
            break
    return found
