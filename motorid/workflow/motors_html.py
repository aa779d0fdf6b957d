"""Several motors on one page: a table with intervals, what differs, and all curves together."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from motorid.estimate.results.estimate import PARAMETERS
from motorid.report.numbers import percent, scaled_unit, significant
from motorid.report.page import figure, paragraph, section
from motorid.report.page import page as whole
from motorid.report.plot import Plot, axis, legend, thin
from motorid.workflow.compare_html import WIDE, style
from motorid.workflow.motors import REAL, Motor, difference, said

POINTS = 80_000  # of all curves together: 1 MB of path text
MOST_COLUMNS, FEWEST_COLUMNS = 700, 60  # of a curve, two points each
WORDS = (
    "The first motor is the reference. ± is 95 %. A difference is real where it is beyond "
    f"{REAL:g} standard uncertainties of the difference. What two captures of one rig share "
    "cancels in it. One capture of a motor can't show how it differs from run to run."
)


def page(found: Sequence[Motor]) -> str:
    """The whole page."""
    title = f"{len(found)} motors"
    body = [
        WIDE,
        style(len(found)),
        f"<header><h1>{title}</h1></header>",
        section("Parameters", _table(found), paragraph(WORDS, "note")),
        section("What differs", "".join(paragraph(line) for line in said(found))),
        section("Curves", *_curves(found), more=True),
    ]
    return whole(title, body)


def _table(found: Sequence[Motor]) -> str:
    head = "".join(f'<th colspan="2">{name}</th>' for name in PARAMETERS)
    rows = "".join(
        f"<tr><td class=name>{escape(motor.label)}</td>{_cells(motor, found)}</tr>"
        for motor in found
    )
    return (
        f'<div class="scroll"><table class="motors"><thead><tr><th>motor</th>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _cells(motor: Motor, found: Sequence[Motor]) -> str:
    if motor.fit.failure:
        return f'<td class="wrap" colspan="{2 * len(PARAMETERS)}">{escape(motor.fit.failure)}</td>'
    out = []
    for name in PARAMETERS:
        value = motor.fit.values.get(name, {})
        if value.get("value") is None:
            out.append(f"<td colspan=2>{escape(str(value.get('status', '')))}</td>")
            continue
        size, half = float(value["value"]), 1.96 * float(value["total"] or 0.0)
        unit, factor = scaled_unit(str(value["unit"]), abs(size))
        places = significant(size * factor, 5)
        apart = difference(motor, found[0], name)
        mark = f"{100 * apart.share:+.2g} %" if apart else ""
        kind = "num real" if apart and apart.real else "num soft"
        out.append(
            f'<td class="num">{escape(places)} {escape(unit)}<br>'
            f'<span class="soft">± {percent(half / abs(size)) if size else "—"}</span></td>'
            f'<td class="{kind}">{escape(mark)}</td>'
        )
    return "".join(out)


def _curves(found: Sequence[Motor]) -> list[str]:
    """Every channel, all motors over one another."""
    seen = [(k, motor) for k, motor in enumerate(found) if motor.capture is not None]
    names = dict.fromkeys(n for _, motor in seen for n in motor.capture.channels)  # type: ignore[union-attr]
    keys = legend([(f"c{k}", motor.label) for k, motor in seen])
    columns = POINTS // (2 * max(len(names) * len(seen), 1))
    columns = min(max(columns, FEWEST_COLUMNS), MOST_COLUMNS)
    return [keys, *(_channel(seen, name, columns) for name in names)]


def _channel(seen: Sequence[tuple[int, Motor]], name: str, columns: int) -> str:
    drawn = []
    for k, motor in seen:
        capture = motor.capture
        assert capture is not None
        if name in capture.channels:
            channel = capture.channels[name]
            drawn.append((k, motor.label, channel.unit, capture.time_s, channel.values))
    largest = max(float(np.nanmax(np.abs(v), initial=0.0)) for *_, v in drawn)
    unit, factor = scaled_unit(drawn[0][2], largest)
    word = name.replace("_", " ")
    plot = Plot(
        axis([time for *_, time, _ in drawn], "time, s", margin=0.0),
        axis([values for *_, values in drawn], f"{word}, {unit}", factor),
        f"{word} of all motors against time",
    )
    for k, label, _, time, values in drawn:
        plot.line(*thin(time, values, columns), f"c{k}", label)
    return figure(word, plot.render())
