"""Each log by name; a mistake with the words that name its cause."""

from __future__ import annotations

from dataclasses import replace

from bench.stranger import edits
from bench.stranger.logs import (
    Maker,
    behind,
    board,
    converter,
    scope,
    spoilt,
)
from bench.stranger.plant import Source

FILTER, LATE = r"low-pass|filter", r"late|lag|delay"
SUPPLY = r"supply|limit|foreign|sags"
LOST, CLIPPED = r"(rows are|stretch is) missing", r"satur|stop at|limit"


def _said(channel: str, fact: str, samples: float) -> Maker:
    """Steps with one fact of the chain, which is stated."""

    def change(log, m):  # type: ignore[no-untyped-def]
        column, size = {"current": "i", "speed": "w"}[channel], samples / log.rate
        if fact == "filter":
            said = ("--filter", f"{channel}={size:.9g}s")
            return replace(log, filters={column: ("RC", size)}, said=said)
        return replace(log, means={column: size}, said=("--aperture", f"{channel}={size:.9g}"))

    return spoilt(converter("steps"), change)


GOOD: dict[str, Maker] = {
    **{f"board, {d}": board(d) for d in ("steps", "random", "stairs", "one way", "ramp")},
    **{f"converter, {d}": converter(d) for d in ("steps", "random", "sweep", "ramp")},
    **{f"scope, {d}": scope(d) for d in ("steps", "up and down")},
    "board, coast at the end": board("coast at the end"),
    "board, geared": board("steps", gear=19.2),
    "board, a busy PC's stamps": board("steps", clock="busy PC"),
    "board, position": board("steps", columns="vip"),
    "board, no current": board("steps", columns="vw"),
    "board, no voltage": board("steps", columns="iw"),
    "converter, up and down": converter("up and down"),
    "converter, coast at the end": converter("coast at the end"),
    "converter, no motion": converter("steps", columns="vi"),
    "converter, locked": converter("steps", columns="vi", source=Source(locked=True)),
    "converter, jitter": converter("steps", clock="jitter"),
    **{f"board, {d}, jumps at any moment": board(d, phase=None) for d in ("steps", "random")},
    **{
        f"converter, {d}, jumps at any moment": converter(d, phase=None)
        for d in ("steps", "random")
    },
    **{
        f"converter, jumps at {phase:g} of a sample": converter("steps", phase=phase)
        for phase in (0.1, 0.5, 0.9)
    },
    "converter, a weak supply": spoilt(
        converter("steps"), lambda log, m: replace(log, source=Source(ohms=0.25 * m.R))
    ),
    "filter of the current, stated": _said("current", "filter", 4.0),
    "means of the speed, stated": _said("speed", "aperture", 8.0),
}

_STEPS, _BOARD = converter("steps"), board("steps")
BAD: dict[str, tuple[Maker, str]] = {
    **{
        f"{column} behind {kind}, {size:g}": (behind(_STEPS, column, kind, size), FILTER)
        for column, kind, size in (
            ("i", "RC", 4),
            ("i", "2 RC", 3),
            ("i", "Butterworth", 1),
            ("i", "Butterworth", 4),
            ("i", "Butterworth", 12),
            ("i", "Bessel", 4),
            ("v", "RC", 5),
            ("v", "2 RC", 3),
            ("v", "Butterworth", 6),
            ("w", "RC", 20),
            ("w", "2 RC", 10),
            ("w", "Butterworth", 5),
        )
    },
    "i behind Butterworth, random": (behind(converter("random"), "i", "Butterworth", 4), FILTER),
    "i behind RC, ramp": (behind(converter("ramp"), "i", "RC", 4), FILTER),
    "i behind RC, board": (behind(_BOARD, "i", "RC", 2), FILTER),
    **{
        f"{column} late, {name}": (
            spoilt(base, lambda log, m, c=column, k=rows: replace(log, late={c: k / log.rate})),
            LATE,
        )
        for column, name, base, rows in (
            ("i", "converter", _STEPS, 6),
            ("w", "converter", _STEPS, 6),
            ("v", "converter", _STEPS, 6),
            ("w", "board", _BOARD, 3),
            ("v", "board", _BOARD, 1),
            ("v", "up and down", board("up and down"), 3),
        )
    },
    "means of all, not stated": (
        spoilt(_STEPS, lambda log, m: replace(log, means=dict.fromkeys("viw", 1.0 / log.rate))),
        f"{LATE}|{FILTER}|mean",
    ),
    "means of the current over 5": (
        spoilt(_STEPS, lambda log, m: replace(log, means={"i": 5.0 / log.rate})),
        f"{LATE}|{FILTER}|mean",
    ),
    "running mean of the current": (
        spoilt(_STEPS, lambda log, m: replace(log, edit=edits.smoothed("i", 8))),
        f"{LATE}|{FILTER}|mean",
    ),
    **{
        f"supply's current, {d}": (converter(d, drawn=True), SUPPLY)
        for d in ("steps", "one way", "random", "ramp")
    },
    **{
        f"supply limits at {share:g} of stall": (
            spoilt(
                _STEPS,
                lambda log, m, s=share: replace(
                    log, asked=True, source=Source(limit_a=s * m.stall_a)
                ),
            ),
            SUPPLY,
        )
        for share in (0.5, 0.7)
    },
    "0 V logged in a coast": (converter("coast at the end", asked=True), r"bridge|open"),
    "0 V logged in a coast, board": (board("coast at the end", asked=True), r"bridge|open"),
    "current clipped": (
        spoilt(_STEPS, lambda log, m: replace(log, edit=edits.clipped(0.5))),
        CLIPPED,
    ),
    "current offset 3 %": (
        spoilt(_STEPS, lambda log, m: replace(log, edit=edits.offset(0.03))),
        r"offset|zero",
    ),
    "current offset 10 %, board": (
        spoilt(_BOARD, lambda log, m: replace(log, edit=edits.offset(0.1))),
        r"offset|zero",
    ),
    **{
        f"{c} held for 8 rows": (
            spoilt(_STEPS, lambda log, m, c=c: replace(log, edit=edits.held(c, 8))),
            f"held|repeat|{LATE}",
        )
        for c in "viw"
    },
    "rows lost": (spoilt(_STEPS, lambda log, m: replace(log, edit=edits.gone)), LOST),
    "rows lost, board": (spoilt(_BOARD, lambda log, m: replace(log, edit=edits.gone)), LOST),
}
