"""How an object shows itself to a person in Python: a line, a table with a plot, a frame.

The report room draws all of it. This module lies below every other, and so reaches up by name when
a view is asked for: whoever only computes never loads a report.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

VIEWS = "motorid.report.views"


class Look:
    """Views of an estimate or a capture. A dataclass that wants ``brief`` as its repr says so."""

    def brief(self) -> str:
        """One line, as ``repr`` shows it."""
        return str(import_module(VIEWS).brief(self))

    def _repr_html_(self) -> str:
        """What a notebook shows: a table and a plot, whole in itself."""
        return str(import_module(VIEWS).html(self))

    def to_dataframe(self) -> pd.DataFrame:
        """An estimate: a row a quantity, in SI units. A capture: a row a sample, by time in s.

        The units of a capture's columns are in ``attrs["units"]``.
        """
        frame: pd.DataFrame = import_module(VIEWS).frame(self)
        return frame

    def plot(self) -> Any:
        """A matplotlib figure: of an estimate measured against fitted, of a capture each channel.

        Raises UsageError where matplotlib is not installed.
        """
        return import_module(VIEWS).plot(self)
