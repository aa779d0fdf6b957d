"""Rigs of a foreign plant, captured and fitted: one record a rig, and the records as a table."""

from __future__ import annotations

import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.coverage.tables import interval_of_share
from bench.foreign import chain, drawn, joint, spice
from bench.foreign.drawn import NAMES, Rig
from bench.iron import present
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import MotoridError
from motorid.estimate.results.estimate import AUTO, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.identify import fit

Row = dict[str, Any]
PLANTS: dict[str, Callable[[Rig, Path], chain.Trace]] = {"spice": spice.run, "mujoco": joint.run}


@dataclass(frozen=True)
class How:
    """Which plant, with which motors; ``keep``: the folder in which captures stay."""

    kind: str
    effects: bool = False
    short: bool = False
    keep: Path | None = None

    def rig(self, seed: int) -> Rig:
        """The rig of that seed for that plant: MuJoCo's has no bridge and no iron."""
        spiced = self.kind == "spice"
        rig = drawn.draw(seed, effects=self.effects, pwm=spiced, iron=spiced)
        return drawn.shortened(rig) if self.short else rig

    def path(self, seed: int) -> Path | None:
        """Where its capture stays."""
        name = f"{self.kind}-{'effects' if self.effects else 'plain'}-{seed}.h5"
        return None if self.keep is None or self.short else self.keep / name


def captured(rig: Rig, how: How) -> Capture:
    """The rig's capture: the kept one, or a new one."""
    path = how.path(rig.seed)
    if path is not None and path.exists():
        return store.load(path)
    with tempfile.TemporaryDirectory() as folder:
        made = chain.capture(rig, PLANTS[how.kind](rig, Path(folder)))
    if path is not None:
        store.save(made, path)
    return made


def score(seed: int, how: How) -> Row:
    """The record of one rig. Never raises: what went wrong is in it."""
    rig = how.rig(seed)
    row: Row = {
        "seed": seed, "power_w": rig.power_w, "sense": rig.sense, "ripple": rig.iron.ripple,
        "effects": list(present(rig.iron)),
    }  # fmt: skip
    try:
        found = fit([captured(rig, how)], model=AUTO)
    except (MotoridError, spice.SpiceError) as error:
        return row | {"refused": f"{type(error).__name__}: {error}"}
    except Exception as error:  # a study goes on; the record says what broke
        return row | {"crashed": "".join(traceback.format_exception(error))[-2000:]}
    return row | _said(found, rig)


def _said(found: Estimate, rig: Rig) -> Row:
    better = found.alternative
    return {
        "six": {name: _one(found.parameters[name], rig.truth[name]) for name in NAMES},
        "wide": {} if better is None
        else {name: _one(better.parameters[name], rig.truth[name]) for name in NAMES},
        "terms": [] if better is None else list(better.terms),
        "warnings": [d.code for d in found.diagnostics if d.severity != "info"],
        "named": [s.code for s in found.suspects if s.strength == "named"],
    }  # fmt: skip


def _one(p: Parameter, truth: float) -> Row:
    """Relative error and total uncertainty, and whether the interval holds the truth."""
    if p.interval_95 is None or p.value is None or p.total is None:
        return {"status": p.status}
    low, high = p.interval_95
    return {
        "status": p.status,
        "off": p.value / truth - 1.0,
        "u": p.total / truth,
        "half": (high - low) / 2 / truth,
        "holds": low <= truth <= high,
    }


def table(rows: Sequence[Row]) -> str:
    """Coverage of each parameter, with and without doubtful values, and what was said."""
    titles = ("", "holds", "of", "95 % of that", "not doubtful holds", "of", "median u",
              "worst off/u", "wide holds", "of")  # fmt: skip
    lines = ["| " + " | ".join(titles) + " |", "|" + len(titles) * "---|"]
    lines += [_coverage(rows, name) for name in NAMES]
    held, count = _held(rows, NAMES, "six", False)
    sure, sures = _held(rows, NAMES, "six", True)
    lines += [
        "",
        f"all parameters: {held} of {count} hold; {sure} of {sures} that are not doubtful",
    ]
    lines.append("")
    for title in ("terms", "warnings", "named"):
        seen = Counter(code for row in rows for code in row.get(title, ()))
        said = ", ".join(f"{code} {count}" for code, count in seen.most_common())
        lines.append(f"{title}: {said or 'none'}")
    return "\n".join(lines)


def _given(rows: Sequence[Row], name: str, which: str, sure: bool) -> list[Row]:
    found = [row[which][name] for row in rows if row.get(which)]
    return [p for p in found if "holds" in p and not (sure and p["status"] == Status.DOUBTFUL)]


def _held(rows: Sequence[Row], names: Sequence[str], which: str, sure: bool) -> tuple[int, int]:
    given = [p for name in names for p in _given(rows, name, which, sure)]
    return sum(p["holds"] for p in given), len(given)


def _coverage(rows: Sequence[Row], name: str) -> str:
    held, count = _held(rows, [name], "six", False)
    low, high = interval_of_share(held, count)
    sure, sures = _held(rows, [name], "six", True)
    wide, wides = _held(rows, [name], "wide", False)
    given = sorted(_given(rows, name, "six", False), key=lambda p: p["u"])
    u = given[len(given) // 2]["u"] if given else float("nan")
    worst = max((abs(p["off"] / p["u"]) for p in given), default=float("nan"))
    return (
        f"| {name} | {held} | {count} | {low:.0%} to {high:.0%} | {sure} | {sures} | {u:.2%} "
        f"| {worst:.1f} | {wide} | {wides} |"
    )


def line(row: Row) -> str:
    """One rig: its errors over u, starred outside of the interval, in brackets where doubtful."""
    head = f"{row['seed']:4d} {row['power_w']:6.1f} W {row['sense']:<9}"
    if "six" not in row:
        return f"{head} {row.get('refused') or row['crashed'].splitlines()[-1]}"
    cells = []
    for name in NAMES:
        p = row["six"][name]
        cell = f"{p['off'] / p['u']:+.1f}" if "holds" in p else "none"
        cell = f"({cell})" if p["status"] == Status.DOUBTFUL else cell
        cells.append(f"{name} {cell}{'' if p.get('holds', True) else '*'}")
    effects = ", ".join(row["effects"]) or ("ripple" if row["ripple"] else "plain")
    said = " ".join(row["terms"]) or "-", " ".join(row["warnings"])
    return f"{head} {'  '.join(cells)} | {effects} | {' | '.join(said)}"
