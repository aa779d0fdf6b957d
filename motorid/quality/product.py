"""A product: the limits of one type of motor, and how it is measured. Reads products/*.toml."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from motorid.errors import MotoridError, UsageError, nearest
from motorid.estimate.results.estimate import SIX
from motorid.program import Decay, Program, Step, StepKind
from motorid.quality import signed
from motorid.quality.guard_band import RULES, Rule
from motorid.quality.limits import Limit
from motorid.quality.quantities import QUANTITIES, quantity
from motorid.quality.temperature import Temperature
from motorid.toml_file import packaged, read_text, tables_of, unknown

BETTER = "better"  # the model that the data support, where it is another than the six parameters
LONGEST_SERIAL = 64
REPEATS = (
    "count",
    "refuse",
    "reason",
    "release",
)  # what becomes of a serial number that was judged before
ATOM = r"(?:\[[A-Za-z0-9 _./:#-]+\]|\\d|\\\.|[A-Za-z0-9 _/:#-])"
COUNT = r"(?:\{\d{1,2}(?:,\d{1,2})?\}|\?)"
SAFE_PATTERN = re.compile(rf"(?:{ATOM}{COUNT}?)+")
VARIABLE = re.compile(r"\{\d+,\d+\}|\?")
MOST_VARIABLE = 3
MODELS = (SIX, BETTER)
DRIVES = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)


@dataclass(frozen=True)
class SerialRule:
    """What a serial number looks like: a pattern that no text can make slow to match.

    ``repeat``: whether a motor that was judged before is tested again.
    """

    pattern: str
    example: str = ""
    repeat: str = "count"  # or one of REPEATS

    def problem(self, serial: str) -> str:
        """Why ``serial`` is none, and what to do; empty when it is one."""
        if len(serial) <= LONGEST_SERIAL and re.fullmatch(self.pattern, serial, re.ASCII):
            return ""
        shown = repr(serial[:LONGEST_SERIAL]) if serial else "nothing"
        such = f", such as {self.example}" if self.example else ""
        return f"{shown} is no serial number of this product{such}: scan the label again"


@dataclass(frozen=True)
class SelfTest:
    """When a rig counts as sound: a motor has passed on it within the last ``inspections``.

    ``golden``: serial numbers that count; none: of any motor. After ``dead_in_a_row`` motors that
    did not run, a motor must pass before another one is blamed.
    """

    golden: tuple[str, ...] = ()
    inspections: int = 50
    dead_in_a_row: int = 2


@dataclass(frozen=True)
class Product:
    """One type of motor. ``limits`` by quantity, in the order of the file."""

    name: str
    title: str
    program: Program
    limits: Mapping[str, Limit]
    voltage_v: float
    segments: int = 0
    commutations_per_turn: int = 0
    warm_up: Program | None = None
    serial: SerialRule | None = None
    ambient: Limit | None = None
    temperature: Temperature = field(default_factory=Temperature)
    lost_samples: int = 0
    self_test: SelfTest = SelfTest()
    model: str = SIX  # whose parameters are judged: SIX, or the better model's where there is one
    text: str = field(default="", repr=False)
    signature: str = field(default="", repr=False)  # of a named key; see signed.py

    @property
    def digest(self) -> str:
        """SHA-256 of the file: which limits a verdict was by."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def cited(self) -> dict[str, str]:
        """What a verdict says of it among its versions."""
        return {"product": self.digest} | (
            {"product_signature": self.signature} if self.signature else {}
        )


def load_product(name_or_path: str | Path) -> Product:
    """The product of a packaged name or of a TOML file.

    Raises UsageError, naming file and key, when it is absent, unreadable or absurd.
    """
    path = _find(str(name_or_path))
    found = parse(read_text(path, "a product file", UsageError), str(path))
    return replace(found, signature=signed.beside(path))


def presets() -> tuple[str, ...]:
    """Names that ``--product`` takes without a path."""
    return tuple(sorted(path.stem for path in packaged("products").glob("*.toml")))


def parse(text: str, where: str = "product") -> Product:
    """The product that ``text`` (TOML) describes. Raises UsageError."""
    document = tables_of(text, where, UsageError)
    try:
        return _product(document, text, Path(where).stem)
    except MotoridError as error:
        raise UsageError(f"{where}: {error}") from None


def _find(name: str) -> Path:
    path = Path(name)
    preset = packaged("products") / f"{name}.toml"
    if path.name == name and path.suffix == "" and preset.is_file():
        return preset
    if "\0" not in name and path.is_file():
        return path
    hint = nearest(path.stem, presets()) or f"; products are {', '.join(presets())}"
    raise UsageError(f"no product file {name[:60]!r}{hint}")


# ---- the file --------------------------------------------------------------------------------

SECTIONS = (
    "serial", "ambient", "temperature", "motor", "capture", "decision", "self_test", "warm_up",
    "program", "limits",
)  # fmt: skip
AT_LEVELS = ("measured_speed@VOLTS", "measured_current@VOLTS")
RULE_KEYS = ("rule", "r", "coverage_factor", "consumer_risk", "process_mean", "process_sd")
LIMIT_KEYS = ("low", "high", "unit", "low_means", "high_means", *RULE_KEYS)


def _product(document: dict[str, Any], text: str, stem: str) -> Product:
    _known(document, ("name", "title", *SECTIONS), "")
    section = {name: _table(document, name) for name in SECTIONS}
    motor = section["motor"]
    _known(motor, ("voltage_v", "segments", "commutations_per_turn"), "motor")
    _known(section["capture"], ("lost_samples",), "capture")
    segments = int(_number(motor, "segments", "motor", 0, 0, 1000))
    decision = section["decision"]
    _known(decision, (*RULE_KEYS[:4], "model"), "decision")
    model = _text(decision, "model", "decision", SIX)
    if model not in MODELS:
        raise UsageError(f"decision.model must be one of {', '.join(MODELS)}, not {model!r}")
    decision = {key: value for key, value in decision.items() if key != "model"}
    limits = {name: _limit(name, table, decision) for name, table in section["limits"].items()}
    if not limits:
        raise UsageError("[limits] is empty: a product without limits passes everything")
    needs = [n for n in limits if n.startswith("ripple_")]
    if needs and segments < 2:
        raise UsageError(f"limits.{needs[0]} needs motor.segments, the commutator's bars")
    name = _text(document, "name", "", stem)
    return Product(
        name=name,
        title=_text(document, "title", "", name),
        program=_program(section["program"], "program"),
        limits=limits,
        voltage_v=_number(motor, "voltage_v", "motor", None, 1e-3, 1e3),
        segments=segments,
        commutations_per_turn=int(
            _number(motor, "commutations_per_turn", "motor", segments * (1 + segments % 2), 0, 1000)
        ),
        warm_up=_program(section["warm_up"], "warm_up") if section["warm_up"] else None,
        serial=_serial(section["serial"]) if section["serial"] else None,
        ambient=_ambient(section["ambient"]) if section["ambient"] else None,
        temperature=_temperature(section["temperature"]),
        lost_samples=int(_number(section["capture"], "lost_samples", "capture", 0, 0, 1e9)),
        self_test=_self_test(section["self_test"]),
        model=model,
        text=text,
    )


def _self_test(table: dict[str, Any]) -> SelfTest:
    _known(table, ("golden", "inspections", "dead_in_a_row"), "self_test")
    golden = table.get("golden", [])
    if not isinstance(golden, list) or not all(isinstance(one, str) and one for one in golden):
        raise UsageError("self_test.golden must be a list of serial numbers")
    return SelfTest(
        tuple(golden),
        int(_number(table, "inspections", "self_test", 50, 1, 100_000)),
        int(_number(table, "dead_in_a_row", "self_test", 2, 1, 1000)),
    )


def _limit(name: str, table: Any, decision: Mapping[str, Any]) -> Limit:
    found = quantity(name)
    if found is None:
        near = nearest(name, QUANTITIES) or f"; they are {', '.join((*QUANTITIES, *AT_LEVELS))}"
        raise UsageError(f"limits.{name}: there is no such quantity{near}")
    where = f"limits.{name}"
    if not isinstance(table, dict):
        raise UsageError(f"{where} must be a table with low or high")
    _known(table, LIMIT_KEYS, where)
    unit = found.unit
    if _text(table, "unit", where, unit) != unit:
        raise UsageError(f"{where}.unit must be {unit}, in which this quantity is measured")
    low = _number(table, "low", where, -math.inf, -1e12, 1e12)
    high = _number(table, "high", where, math.inf, -1e12, 1e12)
    if not low < high or (math.isinf(low) and math.isinf(high)):
        raise UsageError(f"{where} needs a low below its high, or one of them")
    rule = _rule({**decision, **{k: v for k, v in table.items() if k in RULE_KEYS}}, where)
    return Limit(
        name, unit, low, high, rule, False,
        _text(table, "low_means", where, ""), _text(table, "high_means", where, ""),
    )  # fmt: skip


def _rule(table: Mapping[str, Any], where: str) -> Rule:
    name = table.get("rule", "uncertainty")
    if name not in RULES:
        raise UsageError(f"{where}: rule must be one of {', '.join(RULES)}, not {name!r}")
    rule = Rule(
        name,
        _number(table, "r", where, 1.0, 0, 10),
        _number(table, "coverage_factor", where, 2.0, 0.1, 10),
        _number(table, "consumer_risk", where, 0.025, 1e-9, 0.5),
        _number(table, "process_mean", where, None, -1e12, 1e12) if "process_mean" in table
        else None,
        _number(table, "process_sd", where, None, 1e-15, 1e12) if "process_sd" in table else None,
    )  # fmt: skip
    if name == "global_risk" and (rule.process_mean is None or rule.process_sd is None):
        raise UsageError(f"{where}: a global risk needs process_mean and process_sd")
    return rule


def _serial(table: dict[str, Any]) -> SerialRule:
    _known(table, ("pattern", "example", "repeat"), "serial")
    rule = SerialRule(
        _text(table, "pattern", "serial", ""),
        _text(table, "example", "serial", ""),
        _text(table, "repeat", "serial", "count"),
    )
    if rule.repeat not in REPEATS:
        raise UsageError(f"serial.repeat must be one of {', '.join(REPEATS)}")
    if not SAFE_PATTERN.fullmatch(rule.pattern) or len(rule.pattern) > 200:
        raise UsageError(
            "serial.pattern may hold letters, digits, [classes], \\d and counts such as {6} or "
            "{2,8}, and no groups, * or +, so that no scanned text can make it slow"
        )
    if len(VARIABLE.findall(rule.pattern)) > MOST_VARIABLE:
        raise UsageError(f"serial.pattern may hold {MOST_VARIABLE} variable counts at most")
    try:
        problem = rule.problem(rule.example) if rule.example else ""
    except re.error as error:
        raise UsageError(f"serial.pattern is no pattern: {error}") from None
    if problem:
        raise UsageError("serial.example does not match serial.pattern")
    return rule


def _ambient(table: dict[str, Any]) -> Limit:
    _known(table, ("low_c", "high_c"), "ambient")
    low = _number(table, "low_c", "ambient", None, -100, 300)
    high = _number(table, "high_c", "ambient", None, -100, 300)
    if not low < high:
        raise UsageError("ambient.low_c must be below ambient.high_c")
    advice = "let motor and bench come to a temperature within it"
    return Limit("ambient", "°C", low, high, Rule("simple"), True, advice, advice)


def _temperature(table: dict[str, Any]) -> Temperature:
    usual = asdict(Temperature())
    _known(table, tuple(usual), "temperature")
    known = {n: default for n, default in usual.items() if n in table or default is not None}
    return Temperature(
        **{n: _number(table, n, "temperature", default, -200, 200) for n, default in known.items()}
    )


def _program(table: dict[str, Any], where: str) -> Program:
    _known(table, ("steps",), where)
    steps = table.get("steps")
    if not isinstance(steps, list) or not 0 < len(steps) <= 200:
        raise UsageError(f"[[{where}.steps]] must name 1 to 200 steps")
    return Program(tuple(_step(step, f"{where}.steps[{n}]") for n, step in enumerate(steps)))


def _step(table: Any, where: str) -> Step:
    if not isinstance(table, dict):
        raise UsageError(f"{where} must be a table")
    _known(table, ("kind", "duration_s", "volts", "duty", "decay"), where)
    kinds = {kind.name.lower(): kind for kind in StepKind}
    kind = kinds.get(str(table.get("kind")))
    if kind is None:
        raise UsageError(f"{where}.kind must be one of {', '.join(kinds)}")
    duration = _number(table, "duration_s", where, None, 1e-6, 1e6)
    if kind not in DRIVES:
        _known(table, ("kind", "duration_s"), f"{where} ({table['kind']})")
        return Step(kind, duration)
    level = _number(table, "volts" if kind is StepKind.DRIVE_VOLTS else "duty", where, None,
                    -1e3, 1e3)  # fmt: skip
    decays = {d.name.lower(): d for d in Decay if d}
    decay = decays.get(str(table.get("decay", "synchronous_slow")))
    if decay is None:
        raise UsageError(f"{where}.decay must be one of {', '.join(decays)}")
    return Step(kind, duration, level, decay)


def _known(table: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    if problem := unknown(table, keys, where):
        raise UsageError(problem)


def _table(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise UsageError(f"[{name}] must be a table")
    return table


def _text(table: Mapping[str, Any], key: str, where: str, default: str) -> str:
    value = table.get(key, default)
    if not isinstance(value, str) or len(value) > 1000:
        raise UsageError(f"{where}.{key} must be a short text".lstrip("."))
    return value


def _number(
    table: Mapping[str, Any], key: str, where: str, default: float | None, low: float, high: float
) -> float:
    """A number within reason; without a default it must be given."""
    if key not in table:
        if default is None:
            raise UsageError(f"{where}.{key} is missing")
        return float(default)
    value = table[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise UsageError(f"{where}.{key} must be a number from {low:g} to {high:g}, not {value!r}")
    return float(value)
