"""Several motors on one page: a table with intervals, what differs, and all curves together."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from motorid.capture.model import Capture
from motorid.estimate.results.estimate import PARAMETERS
from motorid.report.numbers import percent, scaled_unit, significant
from motorid.report.page import figure, paragraph, section
from motorid.report.page import page as whole
from motorid.report.plot import WIDE, Plot, axis, columns_for, legend, style, thin
from motorid.workflow.motors import REAL, Motor, difference, said

POINTS = 80_000  # of all curves together: 1 MB of path text
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
    seen = [(k, one.label, one.capture) for k, one in enumerate(found) if one.capture is not None]
    names = dict.fromkeys(name for _, _, capture in seen for name in capture.channels)
    columns = columns_for(POINTS, len(names) * len(seen))
    keys = legend([(f"c{k}", label) for k, label, _ in seen])
    return [keys, *(_channel(seen, name, columns) for name in names)]


def _channel(seen: Sequence[tuple[int, str, Capture]], name: str, columns: int) -> str:
    drawn = [(f"c{k}", label, capture) for k, label, capture in seen if name in capture.channels]
    channels = [capture.channels[name] for *_, capture in drawn]
    largest = max(float(np.nanmax(np.abs(one.values), initial=0.0)) for one in channels)
    unit, factor = scaled_unit(channels[0].unit, largest)
    word = name.replace("_", " ")
    plot = Plot(
        axis([capture.time_s for *_, capture in drawn], "time, s", margin=0.0),
        axis([one.values for one in channels], f"{word}, {unit}", factor),
        f"{word} of all motors against time",
    )
    for (kind, label, capture), channel in zip(drawn, channels, strict=True):
        plot.line(*thin(capture.time_s, channel.values, columns), kind, label)
    return figure(word, plot.render())
