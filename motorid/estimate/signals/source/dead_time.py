"""What the dead time of a bridge takes from duty times supply, by the mean current.

In a dead time no switch carries the current. While it flows in the drive's direction the diodes
turn it against the supply, so that the on part begins late; while it flows against the drive they
begin the on part in time and end it late. A current that comes to rest in between leaves the motor
its back-EMF. So the loss falls from all to nothing as the lowest current of the ripple passes zero,
and to as much less than nothing as the highest does; in between it is straight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.signals.source.current_transient import PLACES, Rise, swing_at_start
from motorid.estimate.signals.source.pwm_bridge import (
    DIODE_DROPS_V,
    SWITCHED,
    driven_share,
    ripple,
    swings,
)
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay

Floats = NDArray[np.float64]

UNSURE = 0.06  # of the current at which the ripple turns round: its relative standard uncertainty
COMMUTATION = 0.0015  # of the back-EMF: what is left of a commutator's ripple over a PWM period
FAR = 4.0  # standard deviations beyond which nothing is blurred
BLURRED = np.linspace(-FAR, FAR, 17)
HALVINGS = 40  # of what a source may be higher by
STEP_A = 1e-6  # a volt of _Period: without inductance there is no ripple, and the loss is a step
ALL, NOTHING = 5, 3  # of the six points: the lowest current stays with the drive, or against it


@dataclass(frozen=True)
class DeadTime:
    """Of one part: ``volts`` (6,) lost at mean currents ``amperes`` (6,), along its drive.

    From one to the next the loss is straight, and it stays beyond the ends. Commutation moves the
    current about between the PWM periods of a sample: by ``blur`` (A), a standard deviation.
    """

    side: float
    amperes: Floats
    volts: Floats
    blur: float
    starts: Floats
    firsts: Floats

    @classmethod
    def of(
        cls,
        capture: Capture,
        part: Part,
        inductance_h: float,
        resistance_ohm: float,
        drops_v: float = DIODE_DROPS_V,
    ) -> DeadTime | None:
        """None where nothing switches, or diodes alone do, which need no dead time."""
        rail, pwm_hz = capture.supply_v, capture.wiring.pwm_hz
        duty, swing_v = driven_share(part, rail)
        share = capture.wiring.dead_time_s * pwm_hz
        if part.decay not in SWITCHED or not rail or not 0.0 < share < min(duty, 1 - duty):
            return None
        period, volts, losses = _turned(rail, part.decay, duty, share, drops_v)
        scale = STEP_A
        if inductance_h:
            straight = swings(swing_v, duty, pwm_hz, inductance_h, 0.0)[0]
            bent = ripple(capture, part, inductance_h, resistance_ohm)[0] / straight
            scale = bent / (inductance_h * pwm_hz)
        blur = COMMUTATION * period.mean / resistance_ohm if resistance_ohm else 0.0
        side = 1.0 if part.level > 0 else -1.0
        ahead, against = period.carried
        starts = -scale * share * np.array([against, 0.0, ahead])
        firsts = np.array([losses[NOTHING], share * rail, losses[ALL]])
        return cls(side, scale * volts, losses, blur, starts, firsts)

    @cached_property
    def _corners(self) -> list[tuple[float, float]]:
        """The current at each point, and by how much more an ampere costs beyond it."""
        slopes = np.diff(self.volts) / np.diff(self.amperes)
        bends = np.diff(slopes, prepend=0.0, append=0.0)
        return list(zip(self.amperes.tolist(), bends.tolist(), strict=True))

    def lost(self, current: Floats) -> Floats:
        """V (n,) less in the mean, signed like the terminals, at mean currents (n,)."""
        along = self.side * current
        lost = np.interp(along, self.amperes, self.volts)
        for at, bend in self._corners:
            beyond = along - at
            near = np.flatnonzero(np.abs(beyond) < FAR * self.blur)
            if len(near):
                lost[near] += bend * self.blur * _rounding(beyond[near] / self.blur)
        return np.asarray(self.side * lost)

    def balanced(
        self, current: Floats, taken: Floats, ohms: float, by_readings: bool = False
    ) -> Floats:
        """The current (n,) that loses what it should, of a model that had ``taken`` (n,) from it
        instead, behind ``ohms``, and so found ``current`` (n,).

        ``by_readings``: the source is as high as readings of its voltage say, whatever is lost, so
        that the mean of the current stays.
        """
        drop = current + taken / ohms
        short = (self.lost(current) - taken) / ohms
        low, high = float(short.min()), float(short.max())
        reach = 2.0 * float(np.abs(drop).max() + np.abs(self.volts).max() / ohms) + high - low
        bends = np.add.outer(self.amperes, self.blur * BLURRED).ravel()
        grid = np.unique(self.side * np.concatenate([[-reach], bends, [reach]]))
        along = grid + self.lost(grid) / ohms
        if not by_readings:
            return np.asarray(np.interp(drop, along, grid))
        mean = float(current.mean())
        for _ in range(HALVINGS):
            halfway = (low + high) / 2.0
            if float(np.interp(drop + halfway, along, grid).mean()) < mean:
                low = halfway
            else:
                high = halfway
        return np.asarray(np.interp(drop + (low + high) / 2.0, along, grid))

    def first(self, current: float) -> float:
        """V less in the mean of the first PWM period, which begins with that current.

        It has no ripple of its own yet. A current against the drive or with it may end within the
        dead time, and rests for what is left of it.
        """
        lost = np.interp(self.side * current, self.starts, self.firsts)
        return self.side * float(lost)


def _erf(x: Floats) -> Floats:
    return np.fromiter(map(math.erf, x.tolist()), dtype=np.float64, count=len(x))


def _rounding(over: Floats) -> Floats:
    """By how much the mean of max(x, 0) for x normal about ``over`` (n,) is above max(over, 0)."""
    density = np.exp(-(over**2) / 2.0) / math.sqrt(2.0 * math.pi)
    return np.asarray(density - np.abs(over) * 0.5 * (1.0 - _erf(np.abs(over) / math.sqrt(2.0))))


@dataclass(frozen=True)
class _Period:
    """A PWM period in shares of itself: dead time, on part, dead time, off part.

    ``levels``: volts at the motor in the on part and in the off part; ``carried``, in a dead time
    while its current flows with the drive, and against it. Currents are in volts, to be divided by
    the inductance over the period.
    """

    shares: Floats
    levels: tuple[float, float]
    carried: tuple[float, float]

    @classmethod
    def of(cls, rail: float, decay: Decay, duty: float, dead: float, drops_v: float) -> _Period:
        fast = decay == Decay.FAST  # the whole bridge changes over, through two diodes
        drop = drops_v if fast else drops_v / 2
        off = -rail if fast else 0.0
        shares = np.array([dead, duty - dead, dead, 1.0 - duty - dead])
        return cls(shares, (rail, off), (off - drop, rail + drop))

    @property
    def mean(self) -> float:
        """V without dead time."""
        duty = float(self.shares[0] + self.shares[1])
        return duty * self.levels[0] + (1.0 - duty) * self.levels[1]

    def turns(self) -> list[tuple[float, float]]:
        """Mean current and loss, where the current passes zero at an end of a dead time.

        First the highest current, in the second dead time, then the lowest, in the first.
        """
        ahead, against = self.carried
        return [
            self._at(against, against, 3),
            self._at(against, None, 3),
            self._at(against, ahead, 3),
            self._at(against, ahead, 1),
            self._at(None, ahead, 1),
            self._at(ahead, ahead, 1),
        ]

    def _at(self, first: float | None, second: float | None, zero: int) -> tuple[float, float]:
        """With these volts in the dead times (None: no current flows) and no current at the
        beginning of share ``zero``.
        """
        shown = np.array([first or 0.0, self.levels[0], second or 0.0, self.levels[1]])
        flows = np.array([first is not None, True, second is not None, True])
        mean = float(self.shares[flows] @ shown[flows] / self.shares[flows].sum())
        rises = np.where(flows, (shown - mean) * self.shares, 0.0)
        ends = np.concatenate([[0.0], np.cumsum(rises)])
        ends -= ends[zero]
        return float(self.shares @ (ends[1:] + ends[:-1]) / 2), self.mean - mean


@lru_cache(maxsize=256)  # a fit asks for the same ones with every current
def _turned(
    rail: float, decay: Decay, duty: float, dead: float, drops_v: float
) -> tuple[_Period, Floats, Floats]:
    """A period, and its mean currents (6,) and losses (6,) where the current passes zero."""
    period = _Period.of(rail, decay, duty, dead, drops_v)
    volts, losses = np.array(period.turns()).T.copy()
    for one in (volts, losses):
        one.setflags(write=False)
    return period, volts, losses


def dead_time_loss(
    capture: Capture,
    parts: Sequence[Part],
    current: Floats,
    inductance_h: float,
    resistance_ohm: float = 0.0,
    rises: Sequence[Rise] = (),
    seen: Floats | None = None,
    drops_v: float = DIODE_DROPS_V,
) -> tuple[Floats, Floats]:
    """V that the dead time takes from duty times supply, by the model's ``current``: over every
    interval, (count,), and over readings of the voltage, (count,).

    ``current`` is the mean (count,) over intervals; ``rises``, how it runs within the first ones
    of a part, in which it may pass zero; ``seen`` (16,), what a reading sees of them; ``drops_v``,
    what two diodes drop.
    """
    lost = np.zeros(len(current))
    shown = np.zeros(len(current))
    risen = {rise.part.start: rise for rise in rises}
    for k, part in enumerate(parts):
        dead = DeadTime.of(capture, part, inductance_h, resistance_ohm, drops_v)
        if dead is None:
            continue
        lost[part.slice] = shown[part.slice] = dead.lost(current[part.slice])
        if part.start in risen:
            rise = risen[part.start]
            swing = swing_at_start(capture, parts[k - 1], inductance_h, resistance_ohm) if k else 0
            over = _within(capture, rise, dead, float(current[part.start - 1]) - swing)
            lost[rise.where] = rise.mean(over)
            shown[rise.where] = rise.mean(over) if seen is None else over @ seen
    return lost, shown


def _within(capture: Capture, rise: Rise, dead: DeadTime, found: float) -> Floats:
    """V (k, 16) lost in the PWM period of every place of the first intervals of a part, which
    ``found`` that current (A).
    """
    periods = capture.wiring.pwm_hz * capture.period_s
    late = ahead_a = 0.0
    if rise.part.decay == Decay.FAST and rise.part.level < 0:  # forward is what comes first
        late = 1.0 - driven_share(rise.part, capture.supply_v)[0]
        ahead_a = float(dead.amperes[NOTHING - 1] - dead.amperes[NOTHING])
    within = rise.at((np.floor(PLACES * periods) + late) / periods)
    over = dead.lost(within.ravel()).reshape(within.shape)
    over[0, PLACES * periods < 1.0] = dead.first(found + dead.side * ahead_a)
    return np.asarray(over)


def swinging(
    capture: Capture,
    part: Part,
    current: Floats,
    taken: Floats,
    inductance_h: float,
    resistance_ohm: float,
    source_ohm: float = 0.0,
    by_readings: bool = False,
) -> Floats:
    """A (n,) by which a model's mean ``current`` (count,) of a part departs from one that loses
    what it should; ``by_readings`` as in ``DeadTime.balanced``.

    Where the loss turns, it changes by many times R for an ampere: a model that is given the loss
    of its own last current, ``taken`` (count,), swings from all to nothing and back for ever. At
    the motor's speed R i + lost(i) is what drives it, which has one solution.
    """
    here = current[part.slice]
    off = np.zeros(len(here))
    dead = DeadTime.of(capture, part, inductance_h, resistance_ohm)
    if dead is not None and resistance_ohm and len(here) > 1:  # in the first one R i is not all
        ohms = resistance_ohm + source_ohm
        off[1:] = here[1:] - dead.balanced(here[1:], taken[part.slice][1:], ohms, by_readings)
    return off


def turning(
    capture: Capture,
    parts: Sequence[Part],
    current: Floats,
    inductance_h: float,
    resistance_ohm: float,
) -> Floats:
    """V (count,) more for a unit by which the ripple turns the current at a smaller one, relative.

    Taken over UNSURE to either side, as the loss falls too steeply for a derivative.
    """
    lost = np.zeros(len(current))
    for part in parts:
        dead = DeadTime.of(capture, part, inductance_h, resistance_ohm)
        if dead is not None:
            here = current[part.slice]
            more, less = dead.lost(here * (1.0 + UNSURE)), dead.lost(here / (1.0 + UNSURE))
            lost[part.slice] = (more - less) / (2.0 * UNSURE)
    return lost
