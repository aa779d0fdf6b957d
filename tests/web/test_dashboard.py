"""The line's page: its figures are the history's, its filters hold, its links lead on."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from html import unescape
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest
from prometheus_client.parser import text_string_to_metric_families

from motorid.capture import store
from motorid.errors import UsageError
from motorid.quality.history import History, MeasurementRecord, Query, open_history
from motorid.quality.history.records import capture_record
from motorid.quality.line import line
from motorid.web import filters
from motorid.web.address import parse_listen
from motorid.web.dashboard import Dashboard, dashboard_app
from motorid.web.server import Server
from motorid.workflow.access import Tokens
from tests.chromium import Page
from tests.history.records import record
from tests.web.test_live_page import browser, page

__all__ = ["browser", "page"]  # fixtures
CORPUS = Path(__file__).parents[1] / "corpus" / "format_1_0"
HIGH = MeasurementRecord(
    "R", "ohm", 2.9, 0.004, 2.4, 2.8, 0.007, "FAIL", reason="R <b>too</b> high"
)


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Iterator[History]:
    """Forty motors of two stations; every tenth fails, and one of them passes a second test."""
    with open_history(tmp_path_factory.mktemp("line") / "line.db") as made:
        for number in range(40):
            one = record(number, station=f"line-{number % 2}")
            if number % 10 == 0:
                one = replace(one, outcome="FAIL", measurements=(HIGH, *one.measurements[1:]))
            made.add(one)
        made.add(replace(record(41), serial="SN-00010"))
        found = store.load(next(CORPUS.glob("*.h5")))
        made.add(replace(record(42), serial="WITH", captures=(capture_record(found),)))
        yield made


@pytest.fixture(scope="module")
def url(history: History) -> Iterator[str]:
    board = Dashboard(history, [CORPUS])
    with Server(lambda: dashboard_app(board), parse_listen("0")) as server:
        yield server.url


def got(url: str) -> str:
    with urlopen(url, timeout=60) as answer:
        return str(answer.read().decode())


def refused(url: str, **headers: str) -> tuple[int, str]:
    with pytest.raises(HTTPError) as error:
        urlopen(Request(url, headers=headers), timeout=60)
    return error.value.code, error.value.read().decode()


@pytest.mark.slow
def test_yields_reasons_and_stations_are_those_of_the_results(history: History) -> None:
    found = line(history, Query(kind="check"), "R", newest=20)
    assert found.yields.tests == {"PASS": 38, "FAIL": 4, "INVALID": 0}
    assert (found.yields.first.found, found.yields.first.of) == (37, 41)
    assert (found.yields.last.found, found.yields.last.of) == (38, 41)
    assert [(one.name, one.side, one.count) for one in found.reasons] == [("R", "high", 4)]
    assert {one.name: one.yields.tests["FAIL"] for one in found.stations} == {
        "line-0": 4, "line-1": 0,
    }  # fmt: skip
    rows = history.series("R", Query(kind="check"))[-20:]
    assert found.trend is not None
    assert found.trend.values.tolist() == [row.value for row in rows]
    able = found.trend.capability
    assert able is not None
    assert able.mean == pytest.approx(np.mean([row.value for row in rows]))


@pytest.mark.slow
def test_filters_choose_readings_and_counts(history: History) -> None:
    one = line(history, filters.read({"station": "line-0", "serial": "SN-0003*"}).query)
    assert one.yields.count == 20
    assert {len(q.values) for q in one.quantities} == {5}
    none = line(history, filters.read({"product": "another"}).query)
    assert (none.yields.count, none.trend, none.quantity) == (0, None, "")


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ({"form": "x"}, "no filter 'form'"),
        ({"from": "yesterday"}, "from 'yesterday': write a day"),
        ({"to": "9999-12-31T23:59-23:59"}, "to '9999"),
        ({"outcome": "GOOD"}, "PASS, FAIL or INVALID"),
        ({"before": "-1"}, "number of a result"),
        ({"serial": "x" * 201}, "more than 200"),
    ],
)
def test_an_address_that_makes_no_sense_is_refused_in_a_sentence(
    said: dict[str, str], why: str
) -> None:
    with pytest.raises(UsageError, match=why):
        filters.read(said)


@pytest.mark.slow
def test_the_page_leads_from_a_point_to_its_verdict_and_to_the_curves(url: str) -> None:
    text = got(f"{url}?quantity=R")
    assert "90.24 %" in text  # 37 of 41
    assert "resistance at the terminals, as run too high" in text
    points = re.findall(r'<a href="(result/\d+)" tabindex="-1">', text)
    assert len(points) == 3 * 42 - 1  # individuals, ranges, EWMA
    verdict = got(url + points[0])
    assert "SN-00000" in verdict
    assert "R &lt;b&gt;too&lt;/b&gt; high" in verdict
    assert "is not there any more" in verdict
    with_curves = got(url + "result/42")
    assert "The file has the recorded SHA-256" in with_curves
    assert "as it was read against time" in with_curves
    assert 'href="42/report/0"' in with_curves


@pytest.mark.slow
def test_the_report_of_a_cited_capture_is_made_when_it_is_asked_for(url: str) -> None:
    assert "Coulomb torque" in got(url + "result/42/report/0")
    assert refused(url + "result/42/report/1")[0] == 404


@pytest.mark.slow
def test_filters_stand_in_every_link_of_the_page(url: str) -> None:
    text = unescape(got(f"{url}?station=line-0&outcome=FAIL"))
    assert 'value="line-0" selected' in text
    assert "?station=line-0&outcome=FAIL&quantity=K" in text
    assert "SN-00001" not in text
    assert "SN-00010" in text


def test_only_who_has_the_token_sees_it_and_errors_are_sentences(url: str) -> None:
    origin = "/".join(url.split("/")[:3])
    assert refused(f"{origin}/result/1")[0] == 403
    assert refused(url, Host="evil.example")[0] == 403
    code, text = refused(f"{url}?station_=x")
    assert (code, "no filter &#x27;station_&#x27;" in text) == (400, True)
    assert refused(f"{url}result/999999999999999999999999")[0] == 404
    with urlopen(url, timeout=60) as answer:
        rule = answer.headers.get_all("content-security-policy")
    assert len(rule) == 1
    assert "default-src 'none'" in rule[0]
    assert "frame-ancestors 'none'" in rule[0]


def test_metrics_are_read_by_prometheus_own_parser(url: str) -> None:
    found = {family.name: family for family in text_string_to_metric_families(got(f"{url}metrics"))}
    tests = {
        (one.labels["station"], one.labels["outcome"]): one.value
        for one in found["motorid_tests"].samples
        if one.name == "motorid_tests_total"
    }
    assert tests == {("line-0", "PASS"): 16, ("line-0", "FAIL"): 4, ("line-1", "PASS"): 22}
    (reason,) = (one for one in found["motorid_reasons"].samples if one.name.endswith("_total"))
    assert (reason.labels["quantity"], reason.labels["side"], reason.value) == ("R", "high", 4)
    (last,) = found["motorid_last_test_timestamp_seconds"].samples
    assert last.value == record(42).at.timestamp()


@pytest.mark.slow
def test_tokens_of_persons_open_it_to_roles_that_read(history: History, tmp_path: Path) -> None:
    tokens = Tokens(tmp_path / "tokens.json")
    prometheus = tokens.add("prometheus", "auditor")
    operator = tokens.add("eve", "operator")
    with Server(lambda: dashboard_app(Dashboard(history)), parse_listen("0", tokens=tokens)) as at:
        origin = "/".join(at.url.split("/")[:3])
        assert "motorid_tests_total" in got(f"{origin}/{prometheus}/metrics")
        assert refused(f"{origin}/{operator}/") == (
            403,
            "the role operator may not read the history\n",
        )
        tokens.remove("prometheus")
        assert refused(f"{origin}/{prometheus}/metrics")[0] == 403


@pytest.mark.slow
@pytest.mark.long
def test_a_browser_shows_it_without_complaint_and_a_key_finds_every_field(
    url: str, page: Page
) -> None:
    page.open(f"{url}?quantity=R")
    page.wait("document.querySelectorAll('.plot').length >= 3")
    labels = "[...document.querySelectorAll('form.filters label')].map(l => l.control.name)"
    names = ["product", "station", "from", "to", "quantity", "serial", "outcome"]
    assert page.run(labels) == names
    page.run("document.querySelector('[name=station]').value = 'line-1'")
    page.run("document.querySelector('form.filters').submit()")
    page.wait("location.search.includes('station=line-1')")
    page.wait("document.querySelector('dl.tiles dd').textContent.startsWith('22')")
    assert page.complaints == []
