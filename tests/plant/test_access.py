"""Tokens and roles: what a file of tokens keeps, and what each role may do at a station."""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.errors import DataError, MotoridError, UsageError
from motorid.quality.product import load_product
from motorid.rig import load_rig
from motorid.web.address import Address
from motorid.web.guard import CALLER, Guard
from motorid.web.station import Scanner
from motorid.workflow.access import NEEDS, ROLES, Caller, Tokens
from motorid.workflow.check import Line
from motorid.workflow.station import Station
from tests.plant.consumer import valid

MAY = {  # as docs/access.md says
    "operator": {"inspect", "status", "last"},
    "engineer": {"inspect", "status", "last", "history", "end"},
    "auditor": {"status", "last", "history"},
}


@pytest.fixture
def tokens(tmp_path: Path) -> Tokens:
    return Tokens(tmp_path / "tokens.json")


def test_the_file_holds_no_token_and_is_its_owners(tokens: Tokens) -> None:
    shown = {name: tokens.add(name, role) for name, role in (("a", "operator"), ("b", "auditor"))}
    text = tokens.path.read_text()
    assert not any(token in text for token in shown.values())
    if os.name == "posix":
        assert tokens.path.stat().st_mode & 0o777 == 0o600
    assert tokens.caller(shown["b"]) == Caller("b (auditor)", "auditor")
    assert tokens.caller(shown["b"][:-1]) is None
    assert tokens.caller("") is None
    assert tokens.caller("\udcff") is None
    one, two = tokens.all()
    assert one.salt != two.salt
    with pytest.raises(UsageError, match="has a token of 'a'"):
        tokens.add("a", "engineer")
    tokens.remove("a")
    assert tokens.caller(shown["a"]) is None
    with pytest.raises(UsageError, match="no token of 'a'"):
        tokens.remove("a")


@pytest.mark.skipif(os.name != "posix", reason="no such permissions there")
def test_a_file_that_others_read_is_refused(tokens: Tokens) -> None:
    tokens.add("a", "operator")
    tokens.path.chmod(0o644)
    with pytest.raises(DataError, match="chmod 600"):
        tokens.all()


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"schema": "motorid-tokens-1", "tokens": [1]}'])
def test_a_file_that_is_none(text: str, tokens: Tokens) -> None:
    tokens.path.write_text(text)
    tokens.path.chmod(0o600)
    with pytest.raises(DataError, match="no file of tokens"):
        tokens.all()


def test_the_command(tokens: Tokens, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tokens.path)
    assert run(["token", "add", path, "--role", "auditor", "--name", "anna"]) == 0
    token = capsys.readouterr().out.strip()
    assert tokens.caller(token) == Caller("anna (auditor)", "auditor")
    assert run(["token", "list", path]) == 0
    said = capsys.readouterr()
    assert "anna" in said.out
    assert token not in said.out + said.err
    assert run(["token", "add", path, "--role", "king", "--name", "x"]) == 2
    assert run(["token", "remove", path, "--name", "anna"]) == 0
    assert tokens.all() == []


@pytest.fixture
def station(tmp_path: Path) -> Iterator[Station]:
    with Line(load_rig("sim-line"), load_product("sim-disc"), tmp_path) as line:
        yield Station(line, lambda screen: None)


@pytest.mark.parametrize("role", list(ROLES))
def test_what_each_role_may_order(role: str, station: Station, tmp_path: Path) -> None:
    refused = set()
    for order in NEEDS:
        answers: list[dict[str, Any]] = []
        asked = {"order": order, "serial": "D000001", "id": 7}
        station.take(asked, answers.append, Caller(f"x ({role})", role))
        assert answers[0]["id"] == 7
        valid(asked, "order")
        valid(answers[0], "order-answer")
        if "may not" in answers[0].get("message", ""):
            refused.add(order)
    assert set(NEEDS) - refused == MAY[role]
    trail = [json.loads(line) for line in (tmp_path / "trail.jsonl").read_text().splitlines()]
    assert {one["who"] for one in trail} == {f"x ({role})"}
    refusals = [one["reason"] for one in trail if "may not" in one["reason"]]
    assert len(refusals) == len(set(NEEDS) - MAY[role])


def test_a_page_knows_whose_token_opens_it(tokens: Tokens) -> None:
    token = tokens.add("anna", "auditor")
    here = Address("127.0.0.1", 7411, token="x" * 32, tokens=tokens)
    seen: list[Any] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        seen.append((scope["path"], scope[CALLER]))

    async def nothing(message: Any = None) -> Any:
        return {}

    for one in (token, "x" * 32, "y" * 32):
        path = f"/{one}/page"
        scope = {"type": "http", "path": path, "headers": [(b"host", b"127.0.0.1:7411")]}
        asyncio.run(Guard(app, here)(scope, nothing, nothing))
    assert seen == [("/page", Caller("anna (auditor)", "auditor")), ("/page", Caller())]


def test_a_page_scans_as_its_role_may() -> None:
    scanned: list[Any] = []
    asked = {"ask": "scan", "serial": " D000001 "}
    operator = Caller("o (operator)", "operator")
    for caller in (Caller(), operator):
        Scanner(lambda *said: scanned.append(said), caller).hear(asked)
    assert scanned == [("D000001", None), ("D000001", operator)]
    with pytest.raises(MotoridError, match="the role auditor may not"):
        Scanner(lambda *said: scanned.append(said), Caller("a", "auditor")).hear(asked)
