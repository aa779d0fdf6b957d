"""The operator's screen: one big word, what it means, and what to do next."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from motorid.quality.verdict import Outcome, Verdict
from motorid.visible import visible

FONT = {
    "A": (" ███ ", "█   █", "█████", "█   █", "█   █"),
    "D": ("████ ", "█   █", "█   █", "█   █", "████ "),
    "E": ("█████", "█    ", "███  ", "█    ", "█████"),
    "F": ("█████", "█    ", "███  ", "█    ", "█    "),
    "I": ("███", " █ ", " █ ", " █ ", "███"),
    "L": ("█    ", "█    ", "█    ", "█    ", "█████"),
    "N": ("█   █", "██  █", "█ █ █", "█  ██", "█   █"),
    "P": ("████ ", "█   █", "████ ", "█    ", "█    "),
    "R": ("████ ", "█   █", "████ ", "█  █ ", "█   █"),
    "S": (" ████", "█    ", " ███ ", "    █", "████ "),
    "T": ("█████", "  █  ", "  █  ", "  █  ", "  █  "),
    "U": ("█   █", "█   █", "█   █", "█   █", " ███ "),
    "V": ("█   █", "█   █", "█   █", " █ █ ", "  █  "),
    "W": ("█   █", "█   █", "█ █ █", "██ ██", "█   █"),
    "Y": ("█   █", " █ █ ", "  █  ", "  █  ", "  █  "),
}
ROWS = 5
COLOURS = {"PASS": "30;42", "FAIL": "97;41", "INVALID": "30;43", "READY": "97;44", "RUN": "30;46"}
CLEAR = "\x1b[2J\x1b[3J\x1b[H"
NEXT = {
    Outcome.PASS: "Put the motor with the good ones. Scan the next serial number.",
    Outcome.FAIL: "Put the motor with the rejects. Scan the next serial number.",
    Outcome.INVALID: "Leave the motor in the rig, see to it, and scan the same number again.",
}
MOST_REASONS = 4


@dataclass(frozen=True)
class Screen:
    """What is shown: the word, what stands under it, and the next step; of which motor."""

    word: str
    lines: tuple[str, ...]
    next_step: str
    footer: str = ""
    serial: str = ""


def of_verdict(verdict: Verdict, footer: str = "") -> Screen:
    """The screen for a verdict."""
    lines = [f"{verdict.product}   {verdict.serial or 'no serial number'}"]
    if verdict.marginal:
        lines.append("MARGINAL: within its limits, but not by the guard band")
    reasons = verdict.reasons
    lines += reasons[:MOST_REASONS]
    if len(reasons) > MOST_REASONS:
        lines.append(f"and {len(reasons) - MOST_REASONS} more")
    return Screen(str(verdict.outcome), tuple(lines), NEXT[verdict.outcome], footer, verdict.serial)


def render(screen: Screen, *, width: int = 80, colour: bool = False, clear: bool = False) -> str:
    """Text of at most ``width`` columns. The word is there in letters too, colour or not."""
    inner = max(width - 4, 20)
    screen = _visible(screen)
    body = big(screen.word, inner)
    if colour:
        paint = COLOURS.get(screen.word, "0;7")
        body = [f"\x1b[{paint}m{line.center(inner + 2)}\x1b[0m" for line in ["", *body, ""]]
    out = ["", *(f" {line}" for line in body), ""]
    if body and screen.word not in " ".join(body):
        out.append(f"  {screen.word}")
    for line in screen.lines:
        out += textwrap.wrap(line, inner, initial_indent="  ", subsequent_indent="    ")
    out += ["", *textwrap.wrap(f"> {screen.next_step}", inner, initial_indent="  ",
                               subsequent_indent="    ")]  # fmt: skip
    if screen.footer:
        out += ["", f"  {screen.footer}"]
    return (CLEAR if clear else "") + "\n".join(out) + "\n"


def _visible(screen: Screen) -> Screen:
    """The same where what rig, board and product say cannot steer the terminal."""
    lines = tuple(visible(line) for line in screen.lines)
    return Screen(screen.word, lines, visible(screen.next_step), visible(screen.footer))


def big(word: str, width: int) -> list[str]:
    """The word in letters of five rows, or as it is where that is too wide or unknown."""
    if any(letter not in FONT for letter in word):
        return [word]
    rows = [" ".join(FONT[letter][row] for letter in word) for row in range(ROWS)]
    return rows if len(rows[0]) <= width else [word]


def table(verdict: Verdict) -> str:
    """Every measurement in a line: outcome, value, limits, probability of conformance."""
    rows: list[Sequence[str]] = [("", "quantity", "value", "u", "limits", "unit", "conforms")]
    for m in verdict.measurements:
        value, u = m.reading.value, m.reading.uncertainty
        mark = "MARGINAL" if m.marginal and m.outcome is Outcome.FAIL else str(m.outcome)
        rows.append(
            (
                mark,
                m.quantity,
                "?" if value is None else f"{value:.4g}",
                "" if u is None or value is None else f"{u:.1g}",
                f"{m.limit.low:.4g} … {m.limit.high:.4g}".replace("-inf", "").replace("inf", ""),
                "" if m.limit.unit == "1" else m.limit.unit,
                "" if m.conformance is None else f"{m.conformance:.4f}",
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
