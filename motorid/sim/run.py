"""One run of a program on the simulated board: steps, samples, deadlines, trips."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from motorid.sim.bench import Bench, Counts, Guard, Raw, SignCheck
from motorid.sim.stream import U32, Stream
from motorid.wire.codec import encode_event
from motorid.wire.enums import Decay, EndReason, Fault, StepKind

DUTY_UNIT = 1e-6
VOLT_UNIT = 1e-3
Send = Callable[[bytes], None]
Trip = tuple[Fault, int]


def guard_of(config: Mapping[str, int]) -> Guard:
    """The limits of a configuration in SI units."""
    return Guard(
        current_a=config["current_limit_ma"] * 1e-3,
        speed_counts_s=float(config["speed_limit_counts_s"]),
        supply_min_v=config["supply_min_mv"] * 1e-3,
        supply_max_v=config["supply_max_mv"] * 1e-3,
        voltage_v=config["voltage_limit_mv"] * 1e-3,
    )


class Run:
    """From the tick of the first sample to ``done``. ``over`` is true once the bridge is open."""

    def __init__(
        self,
        bench: Bench,
        config: Mapping[str, int],
        steps: Sequence[Mapping[str, int]],
        stream: Stream,
        send: Send,
        start_tick: int,
        clock_hz: int,
    ) -> None:
        self._bench, self._config, self._steps = bench, config, steps
        self.stream, self._send = stream, send
        self._period, self._fast = bench.period_ticks, bench.fast
        self._sign = -1 if config["encoder_reversed"] else 1
        self.tick = start_tick  # of the next sample
        self._start = start_tick
        self._step = -1
        self._step_end = start_tick
        self._end = start_tick + sum(step["ticks"] for step in steps)
        ms = clock_hz // 1000
        self._sign_ticks = config["sign_check_ms"] * ms
        self._signs_begun = False
        self._silence = config["host_silence_ms"] * ms
        self._alive = start_tick
        self._deadline = start_tick + config["run_time_limit_ms"] * ms
        self.over = False
        self.fault = Fault.NONE
        bench.arm(guard_of(config))

    def heard(self, tick: int) -> None:
        """A heartbeat came."""
        self._alive = tick

    def advance(self, samples: int) -> int:
        """Take at most ``samples`` samples, fewer at a boundary; returns how many were taken.

        In a fast burst those are the guard's, and what is kept was taken between them.

        A sample at the tick at which a step begins is taken before the step acts; the run's end is
        no sample.
        """
        first = self.tick
        taken = self._take(min(samples, self._to_boundary()))
        last = first + (taken - 1) * self._period
        self.tick += taken * self._period
        if trip := self._trip(last):
            self._finish(EndReason.FAULT, last, trip)
        elif last == self._end:
            self._finish(EndReason.COMPLETED, last)
        elif last == self._step_end:
            self._next_step()
        return taken

    def _take(self, samples: int) -> int:
        if not self._fast:
            raw, counts = self._bench.run(min(samples, self.stream.space))
            self._keep(self.tick, self._period, raw, counts)
            return len(counts)
        watched = self._bench.run_fast(samples)
        apart = self._period // self._fast
        self._keep(self.tick - (self._fast - 1) * apart, apart, *watched[2:])
        return len(watched[1])

    def _keep(self, tick: int, apart: int, raw: Raw, counts: Counts) -> None:
        """Readings (n, 3) and counts (n,), ``apart`` ticks apart: those within the run."""
        begin = max(0, (self._start - tick) // apart)
        stop = min(len(counts), (self._end - tick) // apart)
        while begin < stop:
            end = min(stop, begin + self.stream.space)
            self.stream.add(tick + begin * apart, raw[begin:end], self._sign * counts[begin:end])
            begin = end

    def _to_boundary(self) -> int:
        """Samples up to the next one at which something may happen."""
        ticks = min(self._step_end, self._deadline, self._alive + self._silence) - self.tick
        return max(-(-ticks // self._period), 0) + 1

    def _trip(self, tick: int) -> Trip | None:
        """What the sample at ``tick`` trips, if anything."""
        fault, value = self._bench.trip
        if fault == Fault.OVER_SPEED:
            return fault, self._sign * value  # as the position is told
        if fault:
            return fault, value
        if tick >= self._deadline and self._deadline < self._end:
            return Fault.RUN_TIME, self._config["run_time_limit_ms"]
        if tick >= self._alive + self._silence and tick < self._end:
            return Fault.HOST_SILENCE, self._config["host_silence_ms"]
        return None

    def _next_step(self) -> None:
        self._step += 1
        step = self._steps[self._step]
        kind, level = StepKind(step["kind"]), step["level"]
        self._begin_signs(level)
        unit = DUTY_UNIT if kind == StepKind.DRIVE_DUTY else VOLT_UNIT
        self._bench.command(kind, level * unit, Decay(step["decay"]))
        self._send(encode_event("phase", index=self._step, tick=self._step_end & U32))
        self._step_end += step["ticks"]

    def _begin_signs(self, level: int) -> None:
        """The first drive's signs are checked, up to its end."""
        if self._signs_begun or not level or not self._sign_ticks:
            self._bench.check_signs(None)
            return
        self._signs_begun = True
        forward, config = 1 if level > 0 else -1, self._config
        check = SignCheck(
            forward=forward,
            forward_counts=forward * self._sign,
            samples=-(-self._sign_ticks // self._period),
            current_a=config["sign_check_ma"] * 1e-3,
            voltage_v=config["sign_check_mv"] * 1e-3,
            counts=config["sign_check_counts"],
        )
        self._bench.check_signs(check)

    def stop(self) -> None:
        """End the run now: the host said so."""
        self._finish(EndReason.STOPPED, self._latest())

    def trip(self, fault: Fault, value: int) -> None:
        """End the run now: the board saw a fault of its own."""
        self._finish(EndReason.FAULT, self._latest(), (fault, value))

    def _latest(self) -> int:
        """Tick of the last sample."""
        return max(self.tick - self._period, self._start)

    def _finish(self, reason: EndReason, tick: int, trip: Trip | None = None) -> None:
        self.over = True
        self._bench.command(StepKind.COAST)
        self._bench.arm(None)
        if trip is not None:
            self.fault = trip[0]
            event = encode_event("fault", fault=trip[0], tick=tick & U32, value=trip[1])
            self._send(event)
        stream = self.stream
        stream.finish()
        self._send(
            encode_event(
                "done",
                reason=reason,
                tick=tick & U32,
                blocks=stream.blocks,
                samples=stream.samples,
                dropped=stream.dropped,
            )
        )
