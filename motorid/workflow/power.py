"""Detection power: motors with graded defects through the simulated line, as a station judges them.

Every trial is one motor: drawn from the spread of good motors, given one defect, inspected by
``Line`` with the product's program and limits. The trials' severities follow the results of
earlier ones (``quality/detection.py``), and each result is a file: the same call goes on.
"""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import UsageError, nearest
from motorid.quality.detection import Range, Trials, most_named
from motorid.quality.power import Power, Study
from motorid.version import __version__
from motorid.workflow.recalibrate import cited
from motorid.workflow.record import SIM, sim_url
from motorid.workflow.tasks import Progress, Result, Task, Workers, run_all

if TYPE_CHECKING:
    from motorid.quality.product import Product
    from motorid.rig import Rig
    from motorid.sim.options import Options

RUNS = "runs"
SPREAD = {  # standard deviations of good motors, relative
    "copper": 0.01,
    "magnet": 0.005,
    "winding": 0.003,
    "friction": 0.05,
    "load_inertia": 0.01,
}
GOOD = "good"  # the trials without a defect


@dataclass(frozen=True)
class Defect:
    """One kind of defect. ``option``: of the simulator, and ``moved`` its value: of what it is
    without the defect, and of the severity. ``range``: of the severities that are tried.
    """

    title: str
    unit: str
    option: str
    moved: Callable[[float, float], float]
    range: Callable[[Options], Range]


def _share(least: float, most: float) -> Callable[[Options], Range]:
    return lambda options: Range(least, most)


def _of_friction(least: float, most: float) -> Callable[[Options], Range]:
    """Severities as torques, between these shares of the motor's dry friction."""

    def found(options: Options) -> Range:
        torque = options.preset.coulomb_nm
        return Range(least * torque, most * torque)

    return found


def _of_windage(options: Options) -> Range:
    """As a coefficient: at the nominal speed between 0.1 % and five times the dry friction."""
    motor = options.preset
    square = (motor.voltage_v / motor.torque_constant_nm_a) ** 2
    return Range(1e-3 * motor.coulomb_nm / square, 5.0 * motor.coulomb_nm / square)


def _of_voltage(least: float, most: float) -> Callable[[Options], Range]:
    return lambda o: Range(least * o.preset.voltage_v, most * o.preset.voltage_v)


def _of_resistance(least: float, most: float) -> Callable[[Options], Range]:
    return lambda o: Range(least * o.preset.resistance_ohm, most * o.preset.resistance_ohm)


def _more(own: float, severity: float) -> float:
    return own * (1.0 + severity)


def _less(own: float, severity: float) -> float:
    return own * (1.0 - severity)


def _added(own: float, severity: float) -> float:
    return own + severity


DEFECTS = {
    "weak-magnet": Defect("weaker magnet", "1", "magnet", _less, _share(2e-3, 0.5)),
    "turns-missing": Defect("fewer turns on each coil", "1", "winding", _less, _share(2e-3, 0.5)),
    "shorted-turns": Defect(
        "shorted turns of one coil", "1", "shorted_turn", _added, _share(2e-3, 0.9)
    ),
    "poor-joint": Defect("more resistance", "1", "copper", _more, _share(2e-3, 1.0)),
    "brush-drop": Defect("brush drop", "V", "brush_drop", _added, _of_voltage(1e-3, 0.3)),
    "brush-bounce": Defect(
        "bouncing brush", "ohm", "brush_bounce", _added, _of_resistance(2e-3, 1.0)
    ),
    "bearing-friction": Defect("more friction", "1", "friction", _more, _share(0.02, 5.0)),
    "one-way-friction": Defect(
        "friction that differs by direction", "1", "asymmetry", _added, _share(2e-3, 0.8)
    ),
    "stiction": Defect("more breakaway torque", "1", "stiction", _more, _share(0.02, 5.0)),
    "cogging": Defect("cogging", "N·m", "cogging", _added, _of_friction(0.02, 20.0)),
    "windage": Defect("windage", "N·m·s²/rad²", "quadratic", _added, _of_windage),
    "unbalance": Defect("unbalance", "N·m", "unbalance", _added, _of_friction(2e-3, 5.0)),
}  # fmt: skip


def study(
    product: Product,
    rig: Rig,
    folder: Path,
    *,
    defects: Sequence[str] = (),
    motors: int = 40,
    good: int = 60,
    spread: Mapping[str, float] | None = None,
    jobs: Workers = 1,
    progress: Progress | None = None,
) -> Study:
    """The power of ``product`` on a simulated ``rig`` for each of ``defects`` (none: all).

    ``motors`` trials of each defect, and ``good`` without one. ``spread``: relative standard
    deviations of good motors, in place of SPREAD's. Raises UsageError for a rig that is not
    simulated, an unknown defect or spread, or a product whose serial numbers have no example.
    """
    chosen = {name: _defect(name) for name in defects} or DEFECTS
    widths = {**SPREAD, **_spread(spread or {})}
    serial = _serial(product)
    options = _options(rig)
    ranges = {name: one.range(options) for name, one in chosen.items()}
    total = good + motors * len(chosen)
    done = 0

    def run(plan: Sequence[tuple[str, float, int]]) -> list[Result]:
        """Trials: defect, severity, number of the motor."""
        nonlocal done
        base = done
        tasks = [_task(product, rig, serial, widths, *one) for one in plan]
        found = run_all(
            tasks,
            folder / RUNS,
            jobs,
            (lambda n, _: progress(base + n, total)) if progress else None,
        )
        done += len(plan)
        return found

    plain = run([(GOOD, 0.0, k) for k in range(good)])
    rejected = [one for one in plain if one["outcome"] != "PASS"]
    tried: dict[str, list[tuple[float, Result]]] = {name: [] for name in chosen}
    while (count := len(next(iter(tried.values())))) < motors:
        plan = []
        for name, limits in ranges.items():
            if count == 0:
                levels = limits.first()[:motors]
            else:
                levels = _trials(limits, tried[name], good, len(rejected)).next()
            levels = levels[: motors - count]
            plan += [(name, limits.severity(k), count + n) for n, k in enumerate(levels)]
        for (name, severity, _), found in zip(plan, run(plan), strict=True):
            tried[name].append((severity, found))
    return Study(
        product.name,
        rig.name,
        good,
        len(rejected),
        _invalid(rejected),
        tuple(most_named([one["named"] for one in rejected])),
        tuple(
            _power(name, one, _trials(ranges[name], tried[name], good, len(rejected)), tried[name])
            for name, one in chosen.items()
        ),
        widths,
    )


def _trials(
    limits: Range, tried: Sequence[tuple[float, Result]], good: int, rejected: int
) -> Trials:
    found = tuple(one["outcome"] != "PASS" for _, one in tried)
    return Trials(limits, tuple(severity for severity, _ in tried), found, good, rejected)


def _power(
    name: str, defect: Defect, trials: Trials, tried: Sequence[tuple[float, Result]]
) -> Power:
    caught = [one for _, one in tried if one["outcome"] != "PASS"]
    named = most_named([one["named"] for one in caught])
    return Power(
        name, defect.title, defect.unit, defect.option, trials, tuple(named), _invalid(caught)
    )


def _invalid(results: Sequence[Result]) -> int:
    return sum(one["outcome"] == "INVALID" for one in results)


def _defect(name: str) -> Defect:
    if name not in DEFECTS:
        raise UsageError(f"there is no defect {name!r}{nearest(name, list(DEFECTS))}")
    return DEFECTS[name]


def _spread(asked: Mapping[str, float]) -> Mapping[str, float]:
    for name, width in asked.items():
        if name not in SPREAD:
            raise UsageError(f"there is no spread of {name!r}{nearest(name, list(SPREAD))}")
        if not 0.0 <= width <= 0.3:
            raise UsageError(f"a spread of {name} is relative, from 0 to 0.3, not {width:g}")
    return asked


def _serial(product: Product) -> str:
    """A serial number that the product takes."""
    rule = product.serial
    if rule is None:
        return "SIMULATED"
    if rule.example:
        return rule.example
    raise UsageError(f"product {product.name} needs serial.example: simulated motors bear it")


def _options(rig: Rig) -> Options:
    from motorid.sim.options import parse_url

    if not rig.port.startswith(SIM):
        raise UsageError(
            f"rig {rig.name} is a real one: power is simulated, so name a rig with a sim:// port"
        )
    return parse_url(rig.port)


def _task(
    product: Product,
    rig: Rig,
    serial: str,
    spread: Mapping[str, float],
    defect: str,
    severity: float,
    number: int,
) -> Task:
    definition = {
        "product": product.digest,
        "port": rig.port,
        **cited(rig),
        "spread": dict(spread),
        "defect": defect,
        "severity": severity,
        "motor": number,
        "motorid": __version__,
    }
    return Task(inspect, (product, rig, serial, dict(spread), defect, severity, number), definition)


def inspect(
    product: Product,
    rig: Rig,
    serial: str,
    spread: Mapping[str, float],
    defect: str,
    severity: float,
    number: int,
) -> Result:
    """One simulated motor through the line: its outcome, and the quantities that did not pass."""
    from motorid.workflow.check import Line

    port = specimen(rig, spread, defect, severity, number)
    with (
        tempfile.TemporaryDirectory() as name,
        Line(replace(rig, port=port), product, Path(name)) as line,
    ):
        verdict = line.inspect(serial).verdict
    named = [m.quantity for m in verdict.measurements if str(m.outcome) != "PASS"]
    return {"outcome": str(verdict.outcome), "named": named}


def specimen(
    rig: Rig, spread: Mapping[str, float], defect: str, severity: float, number: int
) -> str:
    """The port of that motor. Equal numbers are equal good motors under each defect."""
    options = _options(rig)
    draw = random.Random(f"motor {number}")  # noqa: S311 - a motor, not a secret
    told: dict[str, Any] = {}
    for name, width in spread.items():
        own = float(getattr(options, name)) * max(0.05, 1.0 + width * draw.gauss(0.0, 1.0))
        told[name] = own
    seed = draw.randrange(1 << 40)
    if defect != GOOD:
        one = DEFECTS[defect]
        own = told.get(one.option, float(getattr(options, one.option)))
        told[one.option] = one.moved(own, severity)
    words = {name: f"{value:.9g}" for name, value in told.items()}
    return sim_url(rig.port, **words, seed=str(seed), speed="max")
