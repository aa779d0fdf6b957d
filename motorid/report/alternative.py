"""The better model in every form of the report: its values beside the six-parameter ones."""

from __future__ import annotations

from dataclasses import dataclass

from motorid.estimate.results.estimate import (
    PARAMETERS,
    Alternative,
    ChannelFit,
    Estimate,
    Parameter,
    TermTrial,
)
from motorid.report.numbers import half_width, percent, shown, significant
from motorid.report.page import paragraph, section, table
from motorid.report.words import NAMES, name_of, sentence

HEAD = ("", "", "six parameters", "better model", "change", "of its ±")
FIT_HEAD = ("residuals, rms", "six parameters", "better model")
CHANNELS = {"back_emf": "back-EMF while coasting"}
MEANING = {
    "d_Ke": "Ke over Kt, less 1",
    "V_b": "brush drop",
    "i_b": "current of the drop's rise",
    "T_lc": "quadratic load",
    "d_T0": "T0 forwards over mean, less 1",
    "T_s": "breakaway above T0",
    "w_s": "Stribeck speed",
    "T_c": "cogging torque",
    "N_c": "cogging periods a turn",
    "k_K": "ripple of K",
    "k_R": "ripple of R",
    "N_r": "commutations a turn",
    "C_w": "heat capacity of winding",
    "k_w": "cooling rate of winding",
    "J1": "inertia at the motor",
    "J2": "inertia behind the shaft",
    "Ks": "stiffness of the shaft",
    "b": "damping of the shaft",
    "c_load": "friction over torque",
    "a_K": "fall of K with current",
    "i_K": "current where K begins to fall",
    "d_L": "share of L that current takes",
    "i_L": "current that takes half of it",
    "L2_share": "share of L beside eddies",
    "t_e": "time constant of the eddies",
    "c_R": "rise of R with speed",
    "w_R": "speed where R begins to rise",
    "T_f": "T0 at begin less at end",
    "r_f": "rate of T0's change",
    "K_rated": "K at the rated current",
    "L_rated": "L at the rated current",
    "L_1kHz": "L of a meter at 1 kHz",
    "L_pwm": "L at the PWM frequency",
}


@dataclass(frozen=True)
class Row:
    """One parameter under both models, ready to print; "" where there is nothing to say."""

    name: str
    meaning: str
    before: str
    after: str
    change: str
    reaches: str  # the change in half-widths of the six-parameter interval

    @property
    def cells(self) -> tuple[str, ...]:
        """In the order of ``HEAD``."""
        return self.name, self.meaning, self.before, self.after, self.change, self.reaches


def title(better: Alternative) -> str:
    """What it is, and why it stands here."""
    why = "as asked for" if better.asked else "the data ask for it"
    return f"Better model: {better.name.replace('+', ' + ')} ({why})"


def rows(estimate: Estimate, better: Alternative) -> list[Row]:
    """The six, then what the terms add."""
    out = [_row(estimate.parameters[n], better.parameters[n]) for n in PARAMETERS]
    cold = (name for name in estimate.at_25 if name in better.at_25)
    out += [_row(estimate.at_25[name], better.at_25[name]) for name in cold]
    added = (p for name, p in better.parameters.items() if name not in PARAMETERS)
    return out + [Row(p.name, _meaning(p), "", shown(p).text, "", "") for p in added]


def _row(before: Parameter, after: Parameter) -> Row:
    change = reaches = ""
    if before.value and after.value is not None:
        moved = after.value - before.value
        change = _signed(moved / before.value)
        half = half_width(before)
        reaches = significant(abs(moved) / half, 2) if half else ""
    texts = shown(before).text, shown(after).text
    return Row(before.name, name_of(before), *texts, change, reaches)


def _meaning(p: Parameter) -> str:
    return MEANING.get(p.name, NAMES.get(p.name, p.name))


def _signed(share: float) -> str:
    return f"{'−' if share < 0 else '+'}{percent(abs(share))}"


def fits(better: Alternative) -> list[tuple[str, str, str]]:
    """Residuals of every channel before and after."""
    several = len({fit.capture for fit in better.lack_of_fit}) > 1
    return [(_channel(f, several), *_sizes(f)) for f in better.lack_of_fit]


def _channel(fit: ChannelFit, several: bool) -> str:
    where = f" of run {fit.capture + 1}" if several else ""
    return CHANNELS.get(fit.channel, fit.channel) + where


def _sizes(fit: ChannelFit) -> tuple[str, str]:
    before, after = (f"{significant(v, 3)} {fit.unit}" for v in (fit.before, fit.after))
    return before, after


def sentences(better: Alternative) -> list[str]:
    """The equations that are added, and what was tried."""
    out = [sentence(f"{t}: {e}") for t, e in zip(better.titles, better.equations, strict=True)]
    if "L_rated" in better.parameters:
        out.append("K and L of this model are those at no current and low frequency.")
    return out + [_tried(trial) for trial in better.trials]


def _tried(trial: TermTrial) -> str:
    beside = f" beside {' and '.join(trial.beside)}" if trial.beside else ""
    said = "taken" if trial.taken else "not taken"
    unseen = ""
    if trial.left_out is not None:
        unseen = f", and by {significant(trial.left_out, 3)} on captures left out"
    return sentence(
        f"{trial.term}{beside} was tried, and {said}: it raises twice the log-likelihood by "
        f"{significant(trial.gain, 3)} where {significant(trial.needed, 3)} are needed{unseen}"
    )


def as_text(estimate: Estimate) -> list[str]:
    """Blocks of lines for the terminal; none without a better model."""
    better = estimate.alternative
    if better is None:
        return []
    lines = [title(better), *_columns([HEAD, *(row.cells for row in rows(estimate, better))])]
    return ["\n".join(lines), "\n".join(_columns([FIT_HEAD, *fits(better)]))]


def _columns(cells: list[tuple[str, ...]]) -> list[str]:
    widths = [max(len(cell) for cell in column) for column in zip(*cells, strict=True)]
    return [
        "  " + "  ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True)).rstrip()
        for row in cells
    ]


def as_html(estimate: Estimate) -> str:
    """The section of the page; nothing without a better model."""
    better = estimate.alternative
    if better is None:
        return ""
    return section(
        title(better),
        table(HEAD, [row.cells for row in rows(estimate, better)]),
        table(FIT_HEAD, fits(better)),
        *(paragraph(text, "note") for text in sentences(better)),
    )
