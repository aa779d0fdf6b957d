"""The line's page, read-only: it asks the history, and shows what ``quality.line`` makes of it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, MotoridError, UsageError
from motorid.quality.history import History
from motorid.web import filters
from motorid.web.guard import CALLER, HTTP, App, Receive, Scope, Send
from motorid.workflow.access import READ

if TYPE_CHECKING:
    from sqlalchemy import Row
    from starlette.requests import Request
    from starlette.responses import Response

    from motorid.capture.model import Capture
    from motorid.storage.place import Place

SHOWN = 50  # results in the list
LARGEST_ID = 2**62


class Dashboard:
    """The pages of one history; ``folders``: where captures that have moved are looked for."""

    def __init__(self, history: History, folders: Sequence[Place] = ()) -> None:
        self.history, self.folders = history, folders
        self._fitting = threading.Lock()  # one fit at a time, however many ask

    def line(self, request: Request) -> str:
        """The page of the line."""
        from motorid.quality.line import line
        from motorid.report.line import Choice, html

        asked = filters.read(dict(request.query_params))
        rows = self.history.results(asked.query, last=SHOWN, before=asked.before)[::-1]
        older = asked.link(before=str(rows[-1].id)) if len(rows) == SHOWN else ""
        found = line(self.history, asked.query, asked.quantity)
        choice = Choice(asked.chosen, *self.history.places(), asked.link)
        return html(found, choice, rows, Path(self.history.name).name, older)

    def result(self, request: Request) -> str:
        """The page of one result."""
        from motorid.report.result import Cited, html

        number = _number(request)
        row = self.history.result(number)
        if row is None:
            raise UsageError(f"there is no result {number}")
        cited = []
        for record in self.history.captures_of(number):
            try:
                cited.append(Cited(record, self._read(record), ""))
            except (MotoridError, OSError) as error:
                cited.append(Cited(record, None, str(error)))
        others = self.history.same_motor(row) if row.serial else [row]
        return html(row, self.history.measurements(number), cited, others)

    def report(self, request: Request) -> str:
        """The report of a fit of one of its captures, made now."""
        from motorid.report.html import render
        from motorid.workflow.fit import fit_captures

        records = self.history.captures_of(_number(request))
        place = request.path_params["place"]
        if not 0 <= place < len(records):
            raise UsageError("this result rests on no such capture")
        capture = self._read(records[place])
        with self._fitting:
            return render(fit_captures([capture]))

    def _read(self, record: Row[Any]) -> Capture:
        from motorid.storage.captures import load
        from motorid.storage.moved import Moved
        from motorid.workflow.rejudge import found_capture

        return load(found_capture(record, Moved(self.folders)), record.sha256)


def _number(request: Request) -> int:
    number = int(request.path_params["number"])
    if number > LARGEST_ID:
        raise UsageError("there is no such result")
    return number


def dashboard_app(board: Dashboard) -> App:
    """The pages as an application; errors are pages of a sentence."""
    from starlette.applications import Starlette
    from starlette.routing import Route

    routes = [
        Route("/", _page(board.line), methods=["GET"]),
        Route("/metrics", _metrics(board.history), methods=["GET"]),
        Route("/result/{number:int}", _page(board.result), methods=["GET"]),
        Route("/result/{number:int}/report/{place:int}", _page(board.report), methods=["GET"]),
    ]
    return _readers_only(Starlette(routes=routes))


def _readers_only(app: App) -> App:
    """Shows the pages to roles that may read the history."""

    async def answer(scope: Scope, receive: Receive, send: Send) -> None:
        from starlette.responses import PlainTextResponse

        if scope["type"] == HTTP and not scope[CALLER].may(READ):
            said = f"the role {scope[CALLER].role} may not read the history\n"
            await PlainTextResponse(said, 403)(scope, receive, send)
        else:
            await app(scope, receive, send)

    return answer


def _metrics(history: History) -> Callable[[Request], Response]:
    from motorid.web.metrics import exposition

    def answer(_: Request) -> Response:
        from starlette.responses import PlainTextResponse, Response

        try:
            text, kind = exposition(history)
        except MotoridError as error:
            return PlainTextResponse(f"{error}\n", 503)
        return Response(text, media_type=None, headers={"content-type": kind})

    return answer


def _page(made: Callable[[Request], str]) -> Callable[[Request], Response]:
    from motorid.report.page import page, paragraph, policy

    rule = {"content-security-policy": f"{policy()}; form-action 'self'; base-uri 'none'; "
            "frame-ancestors 'none'"}  # fmt: skip

    def answer(request: Request) -> Response:
        from starlette.responses import HTMLResponse

        try:
            return HTMLResponse(made(request), headers=rule)
        except UsageError as error:
            status, said = 404 if "result" in request.url.path else 400, str(error)
        except (DataError, MotoridError) as error:
            status, said = 503, str(error)
        body = ["<h1>This page cannot be shown</h1>", paragraph(said)]
        return HTMLResponse(page("motorid", body), status, headers=rule)

    return answer
