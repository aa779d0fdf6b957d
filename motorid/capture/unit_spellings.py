"""How people and instruments spell units, in several languages, and the spelling used here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_BY_UNIT = {
    "s": "sec secs second seconds sekunde sekunden seconde secondes segundo segundos "
    "secondi с сек 秒",
    "ms": "msec millisecond milliseconds мс 毫秒 ミリ秒",
    "us": "µs μs usec microsecond microseconds мкс 微秒",
    "ns": "nsec nanosecond nanoseconds",
    "min": "minute minutes",
    "A": "amp amps ampere amperes ampère ampères ampér amperios А 安",
    "mA": "milliamp milliamps milliampere мА 毫安",
    "uA": "µA μA",
    "V": "volt volts voltios В 伏",
    "mV": "millivolt millivolts мВ 毫伏",
    "uV": "µV μV",
    "rpm": "rev/min 1/min min-1 min^-1 min⁻¹ /min U/min upm r/min tr/min giri/min obr/min ot/min "
    "omw/min varv/min об/мин 转/分",
    "rad/s": "rad/sec rads/s rad·s-1 rad·s⁻¹ rad.s-1 рад/с",
    "turn/s": "rps rev/s r/s 1/s U/s turns/s tr/s об/с",
    "deg/s": "°/s deg/sec degrees/s dps",
    "rad": "radian radians рад",
    "deg": "° degree degrees grados градус",
    "turn": "rev revs turns revolution revolutions umdrehungen tours",
    "counts": "ticks tick count cnt cnts pulses edges",
    "counts/s": "ticks/s cnt/s count/s pulses/s",
    "N·m": "Nm N*m N.m N-m Н·м Нм",
    "mN·m": "mNm mN*m mN.m",
    "N·cm": "Ncm",
    "oz·in": "ozin oz-in",
    "lb·in": "lbin lb-in",
    "%": "percent prozent pct",
    "°C": "degC celsius C",
    "1": "pwm",
}
_BY_SPELLING = {spelling: unit for unit, words in _BY_UNIT.items() for spelling in words.split()}
_BY_SPELLING[""] = "1"
SPELLINGS: Mapping[str, str] = MappingProxyType(_BY_SPELLING)
SHORTEST = 3  # letters of a spelling whose case says nothing: mA is no MA


def usual(written: str) -> str:
    """The spelling used here; another text as it is."""
    if written in SPELLINGS:
        return SPELLINGS[written]
    folded = written.casefold()
    if len(written) >= SHORTEST and folded in SPELLINGS:
        return SPELLINGS[folded]
    return "rpm" if folded == "rpm" else written
