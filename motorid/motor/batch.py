"""Responses of a whole population of motors to one record, compiled (``batch.c``).

Every model takes candidates (n, p) in SI and returns sums of squared differences (n, channels), or
with ``outputs=True`` the responses (n, channels, samples). The motor rests at the first sample;
the input is held from each sample to the next.

Equations: the review's (5), (6) (``linear``); those with Coulomb torque and an open bridge
(``friction``); (17), (18) (``quadratic``); (19) to (21) with their signs put right (``two_mass``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError

Floats = NDArray[np.float64]
MAX_MATRIX = 6  # batch.c's


@dataclass(frozen=True)
class Record:
    """What the candidates are held against.

    ``input`` (samples,): V (two masses: N·m), held from a sample to the next. ``measured``:
    readings (samples,) by channel name; NaN where there is none. ``open`` (samples,): where the
    bridge is open until the next sample. ``lag_s``: how long before its sample a channel's
    reading was true, at most a sample period. A current that is a mean over an aperture, ending
    a delay before its sample, is modelled as one where there is friction (``FRICTION``).
    """

    period_s: float
    input: Floats
    measured: Mapping[str, Floats]
    open: NDArray[np.bool_] | None = None
    lag_s: Mapping[str, float] | None = None
    current_aperture_s: float = 0.0
    current_delay_s: float = 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured channels, in the order of every answer."""
        return tuple(self.measured)


Run = Callable[[Floats, Record, bool], Floats]


@dataclass(frozen=True)
class Model:
    """A response model: its parameters, the channels it can show, and its compiled run."""

    name: str
    parameters: tuple[str, ...]
    channels: tuple[str, ...]
    run: Run
    states: Mapping[str, int] = field(default_factory=dict)  # where not the channel's own place

    def state(self, channel: str) -> int:
        """Which state of the compiled run a channel shows."""
        return self.states.get(channel, self.channels.index(channel))

    def squares(self, values: Floats, record: Record) -> Floats:
        """Sums of squared differences, (n, channels of the record)."""
        return self.run(self._fitting(values), record, False)

    def outputs(self, values: Floats, record: Record) -> Floats:
        """Responses, (n, channels of the record, samples)."""
        return self.run(self._fitting(values), record, True)

    def _fitting(self, values: Floats) -> Floats:
        if np.ndim(values) != 2 or np.shape(values)[1] != len(self.parameters):
            raise ValueError(
                f"candidates of shape {np.shape(values)} for {len(self.parameters)} parameters"
            )
        return values


def expm(matrices: Floats) -> Floats:
    """Exponentials of small matrices, (n, m, m) with m up to 6."""
    from motorid.motor._batch import ffi, lib

    matrices = np.ascontiguousarray(matrices, dtype=np.float64)
    n, m, columns = matrices.shape
    if m != columns or not 1 <= m <= MAX_MATRIX:
        raise ValueError(f"matrices of {m} by {columns}; they are square, {MAX_MATRIX} at most")
    out = np.empty_like(matrices)
    lib.batch_expm(n, m, ffi.from_buffer("double[]", matrices), ffi.from_buffer("double[]", out))
    return out


def blank(record_like: Floats, channels: tuple[str, ...]) -> dict[str, Floats]:
    """Readings that are not there, for a run that only asks for outputs."""
    return {name: np.full(len(record_like), np.nan) for name in channels}


def _linear(values: Floats, record: Record, outputs: bool) -> Floats:
    R, L, K, B, J = values.T
    system = np.zeros((len(values), 4, 4))  # current, speed, position; voltage
    system[:, 0, 0], system[:, 0, 1], system[:, 0, 3] = -R / L, -K / L, 1 / L
    system[:, 1, 0], system[:, 1, 1] = K / J, -B / J
    system[:, 2, 1] = 1.0
    if "position" not in record.measured:
        system = system[:, [0, 1, 3]][:, :, [0, 1, 3]]
    return _lti(system, LINEAR, record, outputs)


def _two_mass(values: Floats, record: Record, outputs: bool) -> Floats:
    J1, J2, Ks, b = values.T
    system = np.zeros((len(values), 4, 4))  # motor speed, load speed, spring torque; torque
    system[:, 0, 0], system[:, 0, 1] = -b / J1, b / J1
    system[:, 0, 2], system[:, 0, 3] = -1 / J1, 1 / J1
    system[:, 1, 0], system[:, 1, 1], system[:, 1, 2] = b / J2, -b / J2, 1 / J2
    system[:, 2, 0], system[:, 2, 1] = Ks, -Ks
    return _lti(system, TWO_MASS, record, outputs)


def _driven_two_mass(values: Floats, record: Record, outputs: bool) -> Floats:
    R, L, K, B, J1, J2, Ks, b = values.T
    # current, motor speed, motor position, load speed, spring torque; voltage
    system = np.zeros((len(values), 6, 6))
    system[:, 0, 0], system[:, 0, 1], system[:, 0, 5] = -R / L, -K / L, 1 / L
    system[:, 1, 0], system[:, 1, 1] = K / J1, -(B + b) / J1
    system[:, 1, 3], system[:, 1, 4] = b / J1, -1 / J1
    system[:, 2, 1] = 1.0
    system[:, 3, 1], system[:, 3, 3], system[:, 3, 4] = b / J2, -b / J2, 1 / J2
    system[:, 4, 1], system[:, 4, 3] = Ks, -Ks
    return _lti(system, DRIVEN_TWO_MASS, record, outputs)


def _friction(values: Floats, record: Record, outputs: bool) -> Floats:
    R, L, K, B, J, T0 = values.T
    h, n = record.period_s, len(values)
    drive = np.zeros((n, 6, 6))  # current, speed, position, charge; voltage, direction
    drive[:, 0, 0], drive[:, 0, 1], drive[:, 0, 4] = -R / L, -K / L, 1 / L
    drive[:, 1, 0], drive[:, 1, 1], drive[:, 1, 5] = K / J, -B / J, -T0 / J
    drive[:, 2, 1] = drive[:, 3, 0] = 1.0
    held = np.zeros((n, 3, 3))  # current, charge; voltage
    held[:, 0, 0], held[:, 0, 2], held[:, 1, 0] = -R / L, 1 / L, 1.0
    coast = drive[:, [1, 2, 5]][:, :, [1, 2, 5]]  # speed, position; direction
    driven, opened, stuck = expm(h * drive), expm(h * coast), expm(h * held)
    columns = [driven[:, row, column] for row in range(3) for column in (0, 1, 4, 5)]
    columns += [opened[:, row, column] for row in range(2) for column in (0, 2)]
    columns += [stuck[:, 0, column] for column in (0, 2)]
    reading = _window(drive, 3, record)
    columns += [reading[:, column] for column in (0, 1, 4, 5)]
    reading = _window(held, 1, record)
    columns += [reading[:, column] for column in (0, 2)]
    motor = np.column_stack([*columns, K, T0])
    return _call("batch_friction", FRICTION, record, outputs, motor)


def _window(system: Floats, charge: int, record: Record) -> Floats:
    """Row (n, m) that gives the current's reading from the state one sample before.

    The mean over an aperture that lies within the sample is exact; else its end is cut there.
    """
    h = record.period_s
    end = h - min(record.current_delay_s, h)
    begin = max(end - record.current_aperture_s, 0.0)
    if begin == end:  # an instant
        return expm(end * system)[:, 0]
    return np.asarray((expm(end * system) - expm(begin * system))[:, charge] / (end - begin))


def _lti(system: Floats, model: Model, record: Record, outputs: bool) -> Floats:
    states = system.shape[1] - 1
    discrete = expm(record.period_s * system)[:, :states]
    return _call("batch_lti", model, record, outputs, discrete, before=(states,))


def quadratic(substeps: int = 2) -> Model:
    """Equations (17), (18): load Ta sign(w) + Tb w + Tc w |w|, Runge-Kutta within a sample."""

    def run(values: Floats, record: Record, outputs: bool) -> Floats:
        after = (record.period_s, substeps)
        return _call("batch_quadratic", QUADRATIC, record, outputs, values, after=after)

    names = ("R", "L", "c", "J", "Ta", "Tb", "Tc")
    return Model("quadratic load", names, ("current", "speed", "position"), run)


def _check(record: Record) -> None:
    """Raise ValueError where an array is not as long as the input, which the compiled part asks."""
    samples = len(record.input)
    arrays: dict[str, NDArray[Any]] = {"input": record.input, **record.measured}
    if record.open is not None:
        arrays["open"] = record.open
    for name, array in arrays.items():
        if np.shape(array) != (samples,) or not samples:
            raise ValueError(
                f"{name} has shape {np.shape(array)}; the record has {samples} samples"
            )


def _call(
    function: str,
    model: Model,
    record: Record,
    outputs: bool,
    motor: Floats,
    before: tuple[Any, ...] = (),
    after: tuple[Any, ...] = (),
) -> Floats:
    """Hand one batch to the compiled function; returns squares, or outputs where asked."""
    from motorid.motor._batch import ffi, lib

    def doubles(array: Floats) -> Any:
        keep.append(np.ascontiguousarray(array, dtype=np.float64))
        return ffi.from_buffer("double[]", keep[-1])

    keep: list[NDArray[Any]] = []  # buffers live as long as the call
    n, samples, channels = len(motor), len(record.input), record.channels
    unknown = [name for name in channels if name not in model.channels]
    if unknown:
        known = ", ".join(model.channels)
        raise UsageError(f"the {model.name} model has no channel {unknown[0]}: it has {known}")
    _check(record)
    lags = record.lag_s or {}
    squares = np.empty((n, len(channels)))
    responses = np.empty((n, len(channels), samples)) if outputs else np.empty(0)
    is_open = None if record.open is None else np.ascontiguousarray(record.open, dtype=np.uint8)
    request = ffi.new("batch_record *")
    request.samples, request.channels = samples, len(channels)
    request.input = doubles(record.input)
    request.open = ffi.NULL if is_open is None else ffi.from_buffer("unsigned char[]", is_open)
    request.measured = doubles(np.array([record.measured[name] for name in channels]))
    pick = ffi.new("int[]", [model.state(name) for name in channels])
    lag = ffi.new("double[]", [lags.get(name, 0.0) / record.period_s for name in channels])
    request.pick, request.lag = pick, lag
    request.squares = ffi.from_buffer("double[]", squares)
    request.outputs = ffi.from_buffer("double[]", responses) if outputs else ffi.NULL
    getattr(lib, function)(request, n, *before, doubles(motor), *after)
    return responses if outputs else squares


LINEAR = Model("linear", ("R", "L", "K", "B", "J"), ("current", "speed", "position"), _linear)
FRICTION = Model(
    "friction",
    ("R", "L", "K", "B", "J", "T0"),
    ("current", "speed", "position"),
    _friction,
    {"current": 3},  # as it is read; state 0 is its value at the sample
)
QUADRATIC = quadratic()
DRIVEN_TWO_MASS = Model(  # a motor and what it drives, friction at the motor
    "two masses",
    ("R", "L", "K", "B", "J1", "J2", "Ks", "b"),
    ("current", "speed", "position"),
    _driven_two_mass,
)
TWO_MASS = Model("two masses", ("J1", "J2", "Ks", "b"), ("speed", "load_speed"), _two_mass)
