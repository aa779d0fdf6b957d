"""Numbers as a person reads them: a unit that fits, and digits that the uncertainty supports."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status

MINUS = "\N{MINUS SIGN}"
NOTHING = "—"
DIGITS_WITHOUT_UNCERTAINTY = 6
PREFIXES = {
    9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f",
}  # fmt: skip
SYMBOLS = {"ohm": "Ω", "Ohm": "Ω", "ohm·s/rad": "Ω·s/rad", "1": ""}
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
RPM = 30 / math.pi  # in one rad/s
IN_RPM = {"rad/s": "rpm", "rad/s/V": "rpm/V", "rad/(V·s)": "rpm/V", "rad/(s·V)": "rpm/V"}
PREFIXABLE = ("Ω", "H", "N·m", "s", "A", "V", "W", "J")  # units that begin so take a prefix
GRAM_SQUARE_CENTIMETRES = 1e7  # in one kg·m²: what data sheets of small motors use


@dataclass(frozen=True)
class Shown:
    """A value ready to print. ``half`` is the half-width of the 95 % interval, "" where none is.

    ``factor`` times the SI value is the number shown; ``decimals`` are those of both numbers.
    """

    value: str
    half: str
    unit: str
    factor: float
    decimals: int

    @property
    def text(self) -> str:
        """All in one: ``2.603 ± 0.011 Ω``."""
        between = f" ± {self.half}" if self.half else ""
        return f"{self.value}{between} {self.unit}".strip()


def scaled_unit(unit: str, size: float) -> tuple[str, float]:
    """The unit in which ``size`` (SI, of ``unit``) reads best, and the factor from SI to it."""
    unit = SYMBOLS.get(unit, unit)
    if not size or not math.isfinite(size):
        return unit, 1.0
    if unit == "kg·m²" and abs(size) < 1e-2:
        return "g·cm²", GRAM_SQUARE_CENTIMETRES
    power = 3 * math.floor(math.log10(abs(size)) / 3)
    takes = unit == "rad" or any(
        unit == p or unit.startswith((f"{p}/", f"{p}·")) for p in PREFIXABLE
    )
    if not takes or (unit == "rad" and power > 0):
        if -3 <= power <= 3:
            return unit, 1.0
        return f"×10{str(power).translate(SUPERSCRIPTS)} {unit}".strip(), 10.0**-power
    power = min(max(power, min(PREFIXES)), 0 if unit == "s" else max(PREFIXES))
    if power == -3 and abs(size) >= 0.1:  # 0.25 V, not 250 mV
        power = 0
    return PREFIXES[power] + unit, 10.0**-power


def half_width(parameter: Parameter) -> float | None:
    """Half the width of the 95 % interval, in SI; None where there is no interval."""
    interval = parameter.interval_95
    return None if interval is None else (interval[1] - interval[0]) / 2


def shown(parameter: Parameter) -> Shown:
    """The parameter's value and 95 % half-width, rounded to the uncertainty's two digits."""
    unit, factor = scaled_unit(parameter.unit, _size(parameter))
    if parameter.value is None:
        return Shown(NOTHING, "", unit, factor, 0)
    half = half_width(parameter)
    if parameter.status is Status.AT_BOUND and parameter.interval_95 and half:
        return _limit(parameter, unit, factor)
    if not half or not math.isfinite(half):
        plain = significant(parameter.value * factor, DIGITS_WITHOUT_UNCERTAINTY)
        return Shown(plain, "", unit, factor, _decimals_of(plain))
    decimals = decimals_for(half * factor)
    value = fixed(parameter.value * factor, decimals)
    return Shown(value, fixed(half * factor, decimals), unit, factor, max(decimals, 0))


def _limit(parameter: Parameter, unit: str, factor: float) -> Shown:
    """A value at its bound is known from one side only: the far end of its interval."""
    assert parameter.value is not None
    assert parameter.interval_95 is not None
    low, high = parameter.interval_95
    upper = high - parameter.value >= parameter.value - low
    text = significant((high if upper else low) * factor, 2)
    return Shown(f"{'<' if upper else '>'} {text}", "", unit, factor, _decimals_of(text))


def in_rpm(parameter: Parameter) -> str:
    """A speed or a speed constant in rpm, as data sheets give it; "" for anything else."""
    unit = IN_RPM.get(parameter.unit)
    if unit is None or parameter.value is None:
        return ""
    half = (half_width(parameter) or 0.0) * RPM
    decimals = decimals_for(half) if half else 0
    return f"{fixed(parameter.value * RPM, decimals)} {unit}"


def _size(parameter: Parameter) -> float:
    """What the unit must suit: the value, or its uncertainty where that is much larger."""
    half = half_width(parameter) or 0.0
    if parameter.status is Status.AT_BOUND and parameter.interval_95:
        return max(abs(end) for end in parameter.interval_95)
    return max(abs(parameter.value or 0.0), 0.05 * half if math.isfinite(half) else 0.0)


def decimals_for(uncertainty: float) -> int:
    """Decimals that leave two digits of ``uncertainty``; negative: round to tens, hundreds."""
    exponent = math.floor(math.log10(abs(uncertainty)))
    if round(abs(uncertainty) / 10.0 ** (exponent - 1)) == 100:
        exponent += 1
    return 1 - exponent


def fixed(number: float, decimals: int) -> str:
    """``number`` to so many decimals, with a real minus sign; exponents where digits run away."""
    if decimals > 9 or abs(number) >= 1e9:
        return f"{number:.3g}".replace("-", MINUS)
    rounded = round(number, decimals) + 0.0
    return f"{rounded:.{max(decimals, 0)}f}".replace("-", MINUS)


def significant(number: float, digits: int = 4) -> str:
    """``number`` to so many significant digits, without an exponent where that reads well."""
    if not math.isfinite(number):
        return NOTHING
    text = f"{number:.{digits}g}"
    if "e" in text and 1e-4 <= abs(number) < 1e9:
        text = f"{number:.0f}"
    return text.replace("-", MINUS)


def quantity(size: float, unit: str) -> str:
    """Of three digits, in the unit in which it reads best: ``2.60 Ω``."""
    name, factor = scaled_unit(unit, size)
    return f"{significant(size * factor, 3)} {name}".strip()


def percent(share: float | None) -> str:
    """A ratio as a percentage of two digits, or a dash."""
    if share is None or not math.isfinite(share):
        return NOTHING
    text = f"{100 * share:#.2g}".rstrip(".") if share < 0.995 else f"{100 * share:.0f}"
    return f"{text if share else '0'} %"


def relative(parameter: Parameter, part: float | None) -> float | None:
    """``part`` of the parameter's uncertainty as a share of its value."""
    if part is None or not parameter.value:
        return None
    return abs(part / parameter.value)


def aligned(values: list[str], blank: str = " ", dot_blank: str = " ") -> list[str]:
    """Values padded so that their decimal points stand in one column of a fixed-width font."""
    split = [v.partition(".") for v in values]
    whole = max((len(s[0]) for s in split), default=0)
    part = max((len(s[2]) for s in split), default=0)
    if not part:
        return [v.rjust(whole, blank) for v in values]
    return [
        a.rjust(whole, blank) + (dot or dot_blank) + b.ljust(part, blank) for a, dot, b in split
    ]


def _decimals_of(text: str) -> int:
    return len(text.partition(".")[2]) if "e" not in text else 0
