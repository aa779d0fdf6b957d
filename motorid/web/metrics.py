"""A history's counts for Prometheus, read anew at each scrape.

The names are Prometheus' own way: a total of all time counts up, a gauge is as it is now.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from motorid.errors import UsageError
from motorid.quality.history import History, Query
from motorid.quality.history.tallies import FIRST, REASON, TEST, counts
from motorid.version import __version__

if TYPE_CHECKING:
    from prometheus_client.metrics_core import Metric

NEEDED = "metrics need prometheus-client: pip install 'motorid[web]'"


class HistoryMetrics:
    """A collector of prometheus_client."""

    def __init__(self, history: History) -> None:
        self.history = history

    def collect(self) -> Iterator[Metric]:
        """Every metric, by product and station."""
        from prometheus_client.core import (
            CounterMetricFamily,
            GaugeMetricFamily,
            InfoMetricFamily,
        )

        names = ("product", "station", "what", "outcome", "name", "side")
        with self.history.reading() as connection:
            found = counts(connection, Query(), names)
        newest = self.history.results(Query(kind="check"), last=1)
        where = ["product", "station"]
        tests = CounterMetricFamily(
            "motorid_tests", "Motors tested, by verdict.", labels=[*where, "outcome"]
        )
        first = CounterMetricFamily(
            "motorid_first_tests", "First tests of a motor, by verdict.", labels=[*where, "outcome"]
        )
        reasons = CounterMetricFamily(
            "motorid_reasons", "Measurements that decided a FAIL or an INVALID.",
            labels=[*where, "outcome", "quantity", "side"],
        )  # fmt: skip
        for (product, station, what, outcome, name, side), count in sorted(found.items()):
            if what == TEST:
                tests.add_metric([product, station, outcome], count)
            elif what == FIRST:
                first.add_metric([product, station, outcome], count)
            elif what == REASON:
                reasons.add_metric([product, station, outcome, name, side], count)
        yield from (tests, first, reasons)
        last = GaugeMetricFamily(
            "motorid_last_test_timestamp_seconds", "When the newest test was, as Unix time."
        )
        if newest:
            last.add_metric([], newest[0].at.timestamp())
        yield last
        build = InfoMetricFamily("motorid_build", "The version of motorid.")
        build.add_metric([], {"version": __version__})
        yield build


def exposition(history: History) -> tuple[bytes, str]:
    """The text of a scrape and its media type. Raises UsageError without prometheus-client."""
    try:
        from prometheus_client import CollectorRegistry, generate_latest
        from prometheus_client.exposition import CONTENT_TYPE_LATEST
    except ImportError:
        raise UsageError(NEEDED) from None
    registry = CollectorRegistry(auto_describe=False)
    registry.register(HistoryMetrics(history))
    return generate_latest(registry), CONTENT_TYPE_LATEST
