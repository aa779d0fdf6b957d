"""What a station shows its operator between verdicts, and what it tells a line controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from motorid.quality.product import Product
from motorid.report.screen import Screen
from motorid.workflow.behind import Behind
from motorid.workflow.check import Inspection

OUTCOMES = ("PASS", "FAIL", "INVALID")
MOST_NAMED = 5  # serial numbers in a sentence
USUAL_LATE = 3  # verdicts that wait for the history: more are said


def ready(product: Product, said: str = "") -> Screen:
    """Before a motor is in."""
    lines = [product.title, *([said] if said else [])]
    return Screen("READY", tuple(lines), "Put a motor in and scan its serial number.")


def left_over(judged: int, lost: Sequence[str]) -> str:
    """Of an earlier shift: how many inspections were judged now, and which motors never were."""
    said = f"{judged} unfinished inspections were judged. " if judged else ""
    if lost:
        said += f"Ordered before and never judged: {_some(lost)}. Order or scan them again."
    return said


def running(serial: str) -> Screen:
    """While a motor is measured."""
    return Screen("RUN", (serial,), "Keep your hands off the motor: it turns.", "", serial)


def not_kept(serial: str, error: Exception) -> Screen:
    """The disk takes nothing more."""
    return Screen("INVALID", (serial, str(error)), "Call maintenance.", "", serial)


def with_line(screen: Screen, said: str) -> Screen:
    """A screen with a sentence below it."""
    return replace(screen, lines=(*screen.lines, said))


def counted(counts: Mapping[str, int]) -> str:
    """The verdicts of a shift by outcome."""
    return "  ".join(f"{name} {counts[name]}" for name in OUTCOMES)


def tally(
    counts: Mapping[str, int], ignored: int, workers: Sequence[Behind], done: Inspection
) -> str:
    """The shift so far: verdicts, scans that were not taken, what is late behind it."""
    said = counted(counts)
    if ignored:
        said += f"   {ignored} scans ignored: scan after the verdict"
    for one in workers:
        if (late := one.waiting()) > USUAL_LATE:
            said += f"   {late} {one.what} are not {one.where} yet"
    return f"{said}   {sum(done.seconds.values()):.2f} s   Ctrl-D ends the shift"


def summary(done: Inspection) -> dict[str, Any]:
    """What a line controller is told."""
    verdict = done.verdict
    return {
        "serial": verdict.serial,
        "outcome": str(verdict.outcome),
        "marginal": verdict.marginal,
        "reasons": list(verdict.reasons),
        "exit_code": done.exit_code,
        "folder": str(done.folder),
        "seconds": {name: round(value, 4) for name, value in done.seconds.items()},
    }


def _some(serials: Sequence[str]) -> str:
    more = f" and {len(serials) - MOST_NAMED} more" if len(serials) > MOST_NAMED else ""
    return ", ".join(serials[:MOST_NAMED]) + more
