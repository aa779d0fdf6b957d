"""What a mechanical fit noticed: lack of fit and its suspect, slow sampling, undeclared gains."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import SUPPLY, VOLTAGE, Capture
from motorid.estimate.diagnosis import identifiability
from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.mechanical_signals import COMMAND, Motion, drive_of
from motorid.estimate.partial.modulating_functions import COASTING_PWM, SHAPES, SQUARED
from motorid.estimate.results.estimate import Diagnostic

Floats = NDArray[np.float64]

MISFIT = 2.0  # residual variance, in units of what the drive's noise gives, that is lack of fit
AT_AN_END = 3.0  # times its variance: a jump at the end of its interval
SHARE = 0.1  # of the residual power that a suspect must explain
JUMP = 0.3  # of the top speed, between two samples: sampling too slow for the inertia


def find(
    captures: Sequence[Capture],
    motions: Sequence[Motion],
    best: Regression,
    lag: Diagnostic | None = None,
) -> tuple[Diagnostic, ...]:
    """Findings about the data and the fit, the gravest first; ``lag``: what the balance has."""
    lacks = [*_lack_of_fit(motions, best), *([lag] if lag is not None else [])]
    found = [*lacks, *_slow_sampling(motions), *_unsigned(motions)]
    return (*found, *of_captures(captures))


def of_captures(captures: Sequence[Capture]) -> tuple[Diagnostic, ...]:
    """What these channels can tell at best, what import noticed, and gains nobody declared."""
    found = [_knowable(captures[0]), *_duty(captures)]
    notes = dict.fromkeys(note for c in captures for note in c.provenance.get("notes", ()))
    found += [Diagnostic("import", "info", f"On import: {note}.") for note in notes]
    if not any(c.gain_uncertainty for capture in captures for c in capture.channels.values()):
        found.append(
            Diagnostic(
                "gain_undeclared",
                "info",
                "No gain uncertainty is declared for any channel. A sensor's scale error leaves no "
                "residual: it would change these results in proportion.",
            )
        )
    return tuple(found)


def _duty(captures: Sequence[Capture]) -> Iterator[Diagnostic]:
    """That a command and a supply may make the motor's voltage."""
    names = set.intersection(*(set(capture.channels) for capture in captures))
    if VOLTAGE in names or not {COMMAND, SUPPLY} <= names:
        return
    yield Diagnostic(
        "duty_and_supply", "info",
        "The log holds a supply voltage and a command, and no voltage of the motor. If the command "
        "is the duty of a bridge, import their product: --map voltage=COMMAND/FULL*SUPPLY:V, with "
        "the names of both columns, and for FULL the command at full duty, such as 255.",
    )  # fmt: skip


def standing_still(count: int) -> Diagnostic:
    """That some captures say nothing but that the motor does not move."""
    runs = "One capture was" if count == 1 else f"{count} captures were"
    return Diagnostic(
        "standing_still", "info", f"{runs} left out: the motor never moves, because of friction."
    )


def _knowable(capture: Capture) -> Diagnostic:
    """What these channels can tell at best, and the run that would tell the rest."""
    run = identifiability.of_capture(capture)
    best = replace(run, levels=max(run.levels, 3), transient=True)
    note = ""
    if drive_of(capture.channels) == COMMAND:  # volts of an unknown scale
        best = replace(best, channels=best.channels | {VOLTAGE})
        note = ", volts being in units of the command"
    known = identifiability.assess(best)
    told = ", ".join((*known.parameters, *known.combinations)) or "no parameter"
    return Diagnostic(
        "identifiability",
        "info",
        f"These channels ({', '.join(sorted(capture.channels))}) can determine {told} at "
        f"best{note}. "
        f"{identifiability.advice(run)}".rstrip(),
    )


def expected_rms(motions: Sequence[Motion], best: Regression, jumps: float = 1.0) -> float:
    """RMS that the rows would have, were the noise of the readings and what lies between them all
    there is. ``jumps``: times the variance of what lies between.
    """
    variances = []
    for index, motion in enumerate(motions):
        of_drive = motion.drive_noise**2 * motion.period_s
        of_drive += jumps * motion.jumps_variance(best.half_width_s)
        through_inertia = best.coefficients[0] * motion.inertia_noise(best.half_width_s)
        share = float(np.mean(best.rows.capture == index))
        variances.append(share * (of_drive + through_inertia**2))
    return float(np.sqrt(sum(variances)))


def lacks_fit(motions: Sequence[Motion], best: Regression) -> bool:
    """The rows are off by more than noise and the moments of jumps explain."""
    left = float(np.mean(best.residual**2))
    return left > MISFIT * expected_rms(motions, best, AT_AN_END) ** 2


def _lack_of_fit(motions: Sequence[Motion], best: Regression) -> list[Diagnostic]:
    if not lacks_fit(motions, best):
        return []
    expected = expected_rms(motions, best)
    actual = float(np.sqrt(np.mean(best.residual**2)))
    unit, drive = motions[0].drive_unit, motions[0].drive_name.replace("_", " ")
    mean = float(np.sqrt(np.mean((best.residual / best.rows.weight) ** 2)))
    times = f"{actual / expected:.2g} times" if expected else "above"
    suspect = _suspect(best, motions[0].drive_name)
    return [
        Diagnostic(
            "lack_of_fit",
            "warning",
            f"Lack of fit: the {drive} that the model leaves unexplained "
            f"({mean:.3g} {unit} rms over {best.half_width_s:.3g} s) is {times} what the noise of "
            f"the readings gives. {suspect} The intervals are from the scatter between "
            "stretches of motion and from the choice of bandwidth, and so include it.",
        )
    ]


def _suspect(best: Regression, drive: str) -> str:
    """The further friction term that explains most of the residual, if it explains much."""
    matrix, total = best.rows.matrix[:, best.free], float(best.residual @ best.residual)
    gains = []
    for column in range(len(SHAPES)):
        wider = np.column_stack([matrix, best.rows.shapes[:, column]])
        scale = np.maximum(np.sqrt((wider**2).sum(axis=0)), 1e-300)
        left = best.residual - wider / scale @ np.linalg.lstsq(wider / scale, best.residual)[0]
        gains.append(1.0 - float(left @ left) / total)
    most = int(np.argmax(gains))
    if gains[most] < SHARE:
        return (
            "No simple friction term explains it: suspect a load or friction that depends on "
            "position, compliance, or a delay."
        )
    also = COASTING_PWM if SHAPES[most] == SQUARED and drive in (VOLTAGE, COMMAND) else ""
    return f"Suspect: {SHAPES[most]}{also}, which would explain {100 * gains[most]:.0f} % of it."


def _slow_sampling(motions: Sequence[Motion]) -> list[Diagnostic]:
    for motion in motions:
        speed = motion.speed(motion.period_s)
        jump = float(np.abs(np.diff(speed)).max()) / motion.top_speed if motion.top_speed else 0.0
        if jump > JUMP:
            return [
                Diagnostic(
                    "slow_sampling",
                    "warning",
                    f"The speed changes by {100 * jump:.0f} % of its top value between two samples "
                    f"{motion.period_s * 1e3:.3g} ms apart: the accelerations lie between the "
                    "samples, and the inertia rests on what little remains. Sample at least ten "
                    "times as fast.",
                )
            ]
    return []


def _unsigned(motions: Sequence[Motion]) -> list[Diagnostic]:
    if not any(motion.unsigned for motion in motions):
        return []
    return [
        Diagnostic(
            "unsigned_drive",
            "info",
            f"The {motions[0].drive_name} is a magnitude: its sign was taken from the speed, and "
            "stretches where the model says that it may have been reversed were left out.",
        )
    ]
