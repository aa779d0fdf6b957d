"""The history of results: a database that several stations write and everybody reads.

``open_history`` gives a ``History``; records go in whole, once, whoever sends them how often.
"""

from __future__ import annotations

from motorid.quality.history.database import History, open_history
from motorid.quality.history.query import Query
from motorid.quality.history.records import CaptureRecord, MeasurementRecord, ResultRecord
from motorid.quality.history.trail import Entry

__all__ = [
    "CaptureRecord",
    "Entry",
    "History",
    "MeasurementRecord",
    "Query",
    "ResultRecord",
    "open_history",
]
