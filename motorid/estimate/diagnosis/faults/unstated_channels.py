"""Channels of a log that turned out late or smoothed, of which nobody had said so.

The fit has estimated by how much: these are named, and no longer move the parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE
from motorid.estimate.diagnosis import filter_rest
from motorid.estimate.diagnosis.fault import short
from motorid.estimate.diagnosis.faults.filters.low_pass_filter import shown
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.registry import WITHOUT_WORD
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit.logs.log_lags import TAKEN
from motorid.estimate.fit.logs.log_unknowns import readings
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.intersample_voltage import CONTINUOUS, OF_MEANS
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.log_voltage_noise import foreseen

Floats = NDArray[np.float64]

SURE = 3.0  # standard uncertainties beyond which a size is no chance
WORTH_SAYING = 0.4  # samples
LONGER = 1.5  # samples, than a mean since the reading before
SMOOTHING = {
    CURRENT: CURRENT_SMOOTHING.name,
    SPEED: SPEED_SMOOTHING.name,
    VOLTAGE: VOLTAGE_SMOOTHING.name,
}


@dataclass(frozen=True)
class Size:
    """Of a channel's lag or time constant against the other channels', s."""

    channel: str
    seconds: float
    uncertainty_s: float

    def worth_saying(self, period_s: float) -> bool:
        """It is there, and as long as samples are apart."""
        least = max(SURE * self.uncertainty_s, WORTH_SAYING * period_s)
        if self.channel == SPEED:  # one of counts is the mean since the reading before
            least = max(least, 0.5 * period_s + SURE * self.uncertainty_s)
        return self.seconds > least


def suspects(records: Sequence[MotorRecord], solution: Solution) -> list[Suspect]:
    """Every channel that is late or smoothed, each once, of the record where it is most."""
    found: dict[tuple[str, str], tuple[Size, float]] = {}
    for k, (record, own) in enumerate(zip(records, solution.own, strict=True)):
        period = default.period_s(record)
        if not period:
            continue
        covariance = _covariance(k, record, solution)
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        sizes = {
            one.quantity.name: (float(size), float(sd))
            for one, size, sd in zip(record.instances, own, deviations, strict=True)
            if one.quantity in WITHOUT_WORD
        }
        each = [("lag", size) for size in lags(record, sizes)]
        each += [("filtered", size) for size in smoothings(record, sizes)]
        worth = [(kind, size) for kind, size in each if size.worth_saying(period)]
        if not any(size.channel == CURRENT for _, size in worth):
            both = _together(record, own, covariance)
            worth += [(kind, size) for kind, size in both if size.worth_saying(period)]
        for kind, size in worth:
            last = found.get((kind, size.channel))
            if last is None or size.seconds > last[0].seconds:
                found[kind, size.channel] = size, period
    late = found.get(("lag", VOLTAGE))
    if late is not None and _as_likely_without(records, WORTH_SAYING * late[1]):
        del found["lag", VOLTAGE]
    before = records[0].as_stamped
    said = [_said(kind, size, period, before) for (kind, _), (size, period) in found.items()]
    averaged = [*_averaged(records, before), *_kernels(records, solution, before)]
    named = [*averaged, *_taken_earlier(records, before), *said]
    return _with_rest(named, records, solution)


def _covariance(k: int, record: MotorRecord, solution: Solution) -> Floats:
    """Of a record's own unknowns (m, m): by noise of its readings, and by that of its voltage."""
    moved = [step.own for step in foreseen(k, record, solution)]
    return np.asarray(solution.own_covariance[k] + sum(np.outer(own, own) for own in moved))


def _as_likely_without(records: Sequence[MotorRecord], least_s: float) -> bool:
    """An answer under another shape of the voltage has no lag, and is as likely but for chance.

    A voltage that is held comes half a sample later than one that is joined, and of a smooth drive
    no reading tells the two apart.
    """
    most = float(np.log(readings(records)))  # Schwarz
    rivals = [rival for record in records for rival in record.rivals]
    return any(abs(rival.late_s) <= least_s and rival.behind <= most for rival in rivals)


def _with_rest(
    named: list[Suspect], records: Sequence[MotorRecord], solution: Solution
) -> list[Suspect]:
    """The last of them moves the parameters by what the readings show of another filter."""
    moves = filter_rest.moves(records, solution) if named else {}
    if not moves:
        return named
    more = "as far as a low-pass of second order can; the readings show that it is another"
    last = replace(named[-1], evidence=f"{named[-1].evidence} {more}", moves=moves)
    return [*named[:-1], last]


def _taken_earlier(records: Sequence[MotorRecord], before: Mapping[str, float]) -> list[Suspect]:
    """A current that the fit took earlier by whole samples."""
    late = [
        (record.capture.provenance.get(TAKEN, 0.0), default.period_s(record)) for record in records
    ]
    late_s, period_s = max(late)
    return [_said("lag", Size(CURRENT, late_s, 0.0), period_s, before)] if late_s > 0.0 else []


def _averaged(records: Sequence[MotorRecord], before: Mapping[str, float]) -> Iterator[Suspect]:
    """A current that the fit takes for means over several samples."""
    for record in records:
        current, period = record.block(CURRENT), default.period_s(record)
        if current is None or not default.unstated(record, current.channel, "aperture"):
            continue
        width_s = current.channel.window_s
        if width_s > LONGER * period:
            long = f"{1e3 * width_s:.3g} ms ({width_s / period:.2g} samples of the log)"
            yield Suspect(
                "current_averaged", "current",
                f"the current reads as a running mean over {long}; the fit allows for it",
                f"declare it: --aperture current={1e3 * width_s:.3g}ms",
                "named", allowed=True, without=before,
            )  # fmt: skip
            return


def _kernels(
    records: Sequence[MotorRecord], solution: Solution, before: Mapping[str, float]
) -> Iterator[Suspect]:
    """The first channel that the fit takes for averaged from reading to reading."""
    kinds = [(name, *way) for name, ways in SMOOTHED.items() for way in ways.items()]
    for record, own in zip(records, solution.own, strict=True):
        sizes = dict(zip(record.instances, own.tolist(), strict=True))
        for channel, way, quantity in kinds:
            size = sizes.get(Instance(quantity), 0.0)
            if size * way.behind > WORTH_SAYING:
                yield Suspect(
                    f"{channel}_smoothed", channel,
                    f"{shown(channel, way, size)}; the fit allows for it", quantity.remedy,
                    "named", allowed=True, without=before,
                )  # fmt: skip
                return


def lags(record: MotorRecord, sizes: Mapping[str, tuple[float, float]]) -> Iterator[Size]:
    """Of the channels that come later than most do: one moment is the same for all of them."""
    late, current = (sizes.get(q.name, (0.0, 0.0)) for q in (VOLTAGE_LATE, CURRENT_LAG))
    known = {VOLTAGE: (-late[0], late[1]), CURRENT: current, _motion(record): (0.0, 0.0)}
    if record.block(CURRENT) is None:
        del known[CURRENT]
    usual = (
        float(np.median([size for size, _ in known.values()]))
        if len(known) > 2
        else min(size for size, _ in known.values())
    )
    doubt = max(sd for _, sd in known.values())
    for channel, (size, _) in known.items():
        found = Size(channel, size - usual, doubt)
        if channel != VOLTAGE or not _jumped_before_its_reading(record, found):
            yield found


def _jumped_before_its_reading(record: MotorRecord, found: Size) -> bool:
    """A voltage that jumps is seen to at the next reading, up to a sample later, by any clock."""
    waveform = record.sensed.waveform
    if waveform is None or waveform.shape in (*CONTINUOUS, *OF_MEANS):
        return False
    if not len(waveform.steps_off):
        return False
    return 0.0 <= found.seconds <= waveform.period_s + SURE * found.uncertainty_s


def _together(record: MotorRecord, own: Floats, covariance: Floats) -> Iterator[tuple[str, Size]]:
    """Lag and time constant of a current, as the kind that is more of it: behind a held voltage
    readings may tell their sum alone, for both shift an exponential between two jumps.
    """
    places = {one.quantity: k for k, one in enumerate(record.instances)}
    if CURRENT_LAG in places and CURRENT_SMOOTHING in places:
        pair = [places[CURRENT_LAG], places[CURRENT_SMOOTHING]]
        late_s, smooth_s = (float(x) for x in own[pair])
        doubt = float(np.sqrt(max(covariance[np.ix_(pair, pair)].sum(), 0.0)))
        kind = "lag" if late_s > smooth_s else "filtered"
        yield kind, Size(CURRENT, late_s + smooth_s, doubt)


def smoothings(record: MotorRecord, sizes: Mapping[str, tuple[float, float]]) -> Iterator[Size]:
    """Of the channels that are smoother than the least smooth one."""
    known = {c: sizes[name] for c, name in SMOOTHING.items() if name in sizes}
    least = min((size for size, _ in known.values()), default=0.0)
    for channel, (size, sd) in known.items():
        yield Size(channel, size - min(least, 0.0), sd)


def _motion(record: MotorRecord) -> str:
    return POSITION if record.block(POSITION) is not None else SPEED


def _said(kind: str, size: Size, period_s: float, before: Mapping[str, float]) -> Suspect:
    what = short(size.channel)
    long = f"{1e3 * size.seconds:.3g} ms ({size.seconds / period_s:.2g} samples of the log)"
    if kind == "lag":
        within = size.channel == VOLTAGE and size.seconds < period_s
        like = ", as a mean over a sample or a PWM period does beside instants" if within else ""
        return Suspect(
            f"{what}_lag", what,
            f"the {what} comes {long} later than the other channels{like}; the fit allows for it",
            f"stamp all channels alike, or declare it: --delay {what}={size.seconds:.3g}",
            "named", allowed=True, without=before,
        )  # fmt: skip
    return Suspect(
        f"{what}_filtered", what,
        f"the {what} reads as behind a low-pass of {long}; the fit allows for it",
        f"take the filter out, or declare it: --filter {what}={1e3 * size.seconds:.3g}ms",
        "named", allowed=True, without=before,
    )  # fmt: skip
