"""One SCPI instrument: commands whose errors are asked for, numbers, and binary blocks.

After each command the instrument's error queue is read, as SCPI-99 (SYST:ERR?) has it. Numbers are
written with a decimal point whatever the locale, and read as IEEE 488.2's NR1 to NR3.
"""

from __future__ import annotations

import math
import re
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.errors import LinkError, RigError, UsageError
from motorid.visible import visible

FAR = 9.9e37  # SCPI-99's infinity; 9.91e37 is its word for "not a number"
MOST_ERRORS = 20  # read from a queue; an instrument's holds some ten to thirty
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*[A-Za-z%]*\s*\Z")
_ERROR = re.compile(r"\s*([+-]?\d+)\s*(?:,|\Z)")


class Link(Protocol):
    """What carries an instrument's messages. All raise LinkError where it does not answer."""

    def write(self, text: str) -> None: ...

    def ask(self, text: str) -> str: ...

    def block(self, text: str, kind: str, big_endian: bool) -> NDArray[Any]: ...

    def close(self) -> None: ...


class Instrument:
    """A link with a name (``supply``) and the query of its error queue ("": it has none)."""

    def __init__(self, name: str, link: Link, error: str = "SYST:ERR?") -> None:
        self.name, self._link, self._error = name, link, error
        self.identity = ""

    def identify(self) -> str:
        """What it says it is (*IDN?), with its queue of earlier errors emptied.

        Raises LinkError where it says nothing.
        """
        self.identity = self._link.ask("*IDN?").strip()
        if not self.identity:
            raise LinkError(f"the {self.name} answers *IDN? with nothing: is it a SCPI instrument?")
        self._link.write("*CLS")
        self.errors()
        return self.identity

    def command(self, text: str) -> None:
        """Sends one command. Raises RigError where the instrument's error queue refuses it."""
        self._link.write(text)
        if found := self.errors():
            raise RigError(
                f"the {self.name} refused {text!r}: {'; '.join(found)}. Does the dialect suit "
                f"this instrument ({visible(self.identity)})?"
            )

    def ask(self, text: str) -> str:
        """The answer to a query. Raises LinkError, with what the error queue says."""
        try:
            return self._link.ask(text).strip()
        except LinkError as failure:
            raise self._explained(failure) from None

    def number(self, text: str) -> float:
        """The number that answers a query; NaN where the instrument has none. Raises LinkError."""
        return number_of(self.ask(text), f"the {self.name} answers {text!r}")

    def numbers(self, text: str) -> list[float]:
        """The numbers, parted by commas, that answer a query. Raises LinkError."""
        said = f"the {self.name} answers {text!r}"
        return [number_of(part, said) for part in self.ask(text).split(",")]

    def block(self, text: str, kind: str, big_endian: bool = False) -> NDArray[Any]:
        """The readings of a definite or indefinite block (IEEE 488.2 #), of struct's ``kind``."""
        try:
            found = np.asarray(self._link.block(text, kind, big_endian))
        except LinkError as failure:
            raise self._explained(failure) from None
        if not len(found):
            raise self._explained(LinkError(f"the {self.name} answers {text!r} with no reading"))
        return found

    def errors(self) -> list[str]:
        """What its error queue held, oldest first. Raises LinkError on an answer that is none."""
        found: list[str] = []
        while self._error and len(found) < MOST_ERRORS:
            answer = self._link.ask(self._error).strip()
            code = _ERROR.match(answer)
            if code is None:
                raise LinkError(
                    f"the {self.name} answers {self._error!r} with {visible(answer)!r}, which is "
                    "no error of SCPI: correct `error` in its dialect"
                )
            if int(code[1]) == 0:
                break
            found.append(visible(answer))
        return found

    def _explained(self, failure: LinkError) -> LinkError:
        try:
            found = self.errors()
        except LinkError:
            return failure
        return (
            LinkError(f"{failure}; its error queue says {'; '.join(found)}") if found else failure
        )

    def close(self) -> None:
        """Gives the link back."""
        self._link.close()


def number_of(text: str, said: str) -> float:
    """NR1, NR2 or NR3, perhaps with a unit behind it; NaN for SCPI's NAN and INF. LinkError."""
    found = _NUMBER.match(text)
    if found is None:
        raise LinkError(f"{said} with {visible(text.strip()[:60])!r}, which is no number")
    value = float(found[1])
    return math.nan if abs(value) >= FAR * 0.999 else value


def written(value: float) -> str:
    """A number as every instrument reads it (NR2): with a point, without an exponent."""
    whole, _, part = f"{value:.7f}".partition(".")
    return f"{whole}.{part.rstrip('0') or '0'}"


class VisaLink:
    """A link by pyvisa."""

    def __init__(self, resource: Any, where: str) -> None:
        self._resource, self._where = resource, where

    def write(self, text: str) -> None:
        """See Link."""
        self._done(lambda: self._resource.write(text), f"take {text!r}")

    def ask(self, text: str) -> str:
        """See Link."""
        return str(self._done(lambda: self._resource.query(text), f"answer {text!r}"))

    def block(self, text: str, kind: str, big_endian: bool) -> NDArray[Any]:
        """See Link."""

        def fetch() -> Any:
            return self._resource.query_binary_values(
                text, datatype=kind, is_big_endian=big_endian, container=np.array
            )

        return np.asarray(self._done(fetch, f"answer {text!r} with a whole block"))

    def close(self) -> None:
        """See Link."""
        self._resource.close()

    def _done(self, do: Any, what: str) -> Any:
        from pyvisa.errors import InvalidSession, VisaIOError

        try:
            return do()
        except VisaIOError as error:
            why = error.abbreviation.removeprefix("VI_ERROR_").lower()
            text = f"{self._where} does not {what} ({why}): check its cable, power and address"
        except (InvalidSession, OSError, ValueError, UnicodeError) as error:
            text = f"{self._where} does not {what} ({visible(str(error))[:120]})"
        raise LinkError(text)


def open_visa(backend: str, resource: str, timeout_s: float, name: str) -> VisaLink:
    """The instrument behind a VISA resource's name.

    ``backend`` as pyvisa has it: ``@py``, "" for the maker's VISA library, ``FILE.yaml@sim``.
    Raises UsageError without pyvisa, LinkError where nothing can be opened.
    """
    try:
        import pyvisa
    except ImportError:
        raise UsageError(
            "scpi:// needs the packages pyvisa and pyvisa-py: pip install 'motorid[scpi]'"
        ) from None
    where = f"the {name} ({resource})"
    try:
        device: Any = pyvisa.ResourceManager(backend).open_resource(resource)
        device.timeout = timeout_s * 1e3
        device.write_termination = "\n"
        if _is_plain(resource):
            device.read_termination = "\n"
    except (pyvisa.errors.Error, OSError, ValueError) as error:
        said = visible(str(error).splitlines()[0])[:160] if str(error) else type(error).__name__
        raise LinkError(
            f"{where} cannot be opened ({said}): check address, cable and `visa`"
        ) from None
    return VisaLink(device, where)


def _is_plain(resource: str) -> bool:
    """A bare stream, on which messages end with a line feed and nothing else says so."""
    return resource.upper().endswith("SOCKET") or resource.upper().startswith("ASRL")
