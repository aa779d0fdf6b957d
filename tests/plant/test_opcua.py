"""A station as a server of OPC UA, asked by asyncua's client in another process."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.workflow.access import Tokens
from motorid.workflow.opcua.units import CODES, NO_CODE, unit_id
from tests.certificates import pair
from tests.plant.mosquitto import free_port
from tests.quality.controller import Controller
from tests.quality.test_station import running

STATION = "urn:motorid:station"
CLIENT = Path(__file__).with_name("opcua_client.py")


def ask(port: int, *clients: Sequence[str]) -> list[dict[str, Any]]:
    """What each of them saw, one after the other; a client is its serial number and its options."""
    words = [sys.executable, str(CLIENT), f"opc.tcp://127.0.0.1:{port}/motorid"]
    lines = "".join(json.dumps(client) + "\n" for client in clients)
    done = subprocess.run(words, input=lines, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    return [dict(json.loads(line)) for line in done.stdout.splitlines()]


@pytest.mark.slow
def test_an_order_and_its_verdict(tmp_path: Path) -> None:
    port, shift = free_port(), tmp_path / "shift"
    with running(shift, "--opcua", str(port), "--station", "line-1") as (_, orders):
        (said,) = ask(port, ["D000001"])
        controller = Controller(orders)
        assert controller.ask(order="last", serial="D000001")["outcome"] == said["outcome"]
    assert said["accepted"]
    assert said["refused"][0] is False
    assert "scan the label again" in said["refused"][1]
    (path,) = shift.glob("D000001_*/verdict.json")
    stored = json.loads(path.read_text())
    assert said["verdict"] == stored
    assert said["event"] == ["D000001", "PASS", stored["content_sha256"], 100]
    (row,) = [one for one in stored["measurements"] if one["quantity"] == "R_25"]
    assert (said["R_25"], said["u"], said["low"]) == (row["value"], row["uncertainty"], row["low"])
    assert said["unit"] == ["ohm", unit_id("ohm")]
    assert said["kind"] == 17497  # AnalogUnitType
    assert said["states"][0] == "READY"
    assert not said["written"]
    trail = [json.loads(one) for one in (shift / "trail.jsonl").read_text().splitlines()]
    assert [(one["outcome"], one["who"]) for one in trail] == [
        ("accepted", "opcua"), ("refused", "opcua"),
    ]  # fmt: skip


@pytest.mark.slow
def test_security_and_roles(tmp_path: Path) -> None:
    """An encrypted channel and a token; without either nothing is done."""
    port, shift, tokens = free_port(), tmp_path / "shift", Tokens(tmp_path / "tokens.json")
    roles = {role: tokens.add(role, role) for role in ("operator", "auditor")}
    pem, key = pair(tmp_path, uri=STATION)
    mine = pair(tmp_path, "client", uri="urn:motorid:client")
    secured = ("--security", str(mine[0]), str(mine[1]), str(pem))
    options = ("--certificate", str(pem), "--key", str(key), "--tokens", str(tokens.path))
    with running(shift, "--opcua", str(port), *options):
        clear, stranger, watching, said = ask(
            port,
            ["D000001", "--token", roles["operator"]],  # in the clear
            ["D000002", *secured, "--token", "x" * 32],
            ["D000003", *secured, "--token", roles["auditor"]],
            ["D000004", *secured, "--token", roles["operator"]],
        )
    assert "error" in clear
    assert "BadUserAccessDenied" in stranger["error"]
    assert watching == {
        "accepted": False,
        "message": "the role auditor may not give the order inspect",
    }
    assert said["verdict"]["outcome"] == "PASS"
    (inspected,) = shift.glob("D00000*")
    assert inspected.name.startswith("D000004_")
    trail = [json.loads(one) for one in (shift / "trail.jsonl").read_text().splitlines()]
    assert {(one["outcome"], one["who"]) for one in trail} == {
        ("refused", "auditor (auditor) by opcua"),
        ("accepted", "operator (operator) by opcua"),
        ("refused", "operator (operator) by opcua"),
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("more", "why"),
    [
        (["--opcua", "0.0.0.0:4840"], "can be reached from other computers"),
        (["--opcua", "0.0.0.0:4840", "--allow-remote"], "needs TLS"),
        (["--opcua", "0.0.0.0:4840", "--allow-remote", "PAIR"], "add --tokens FILE"),
        (["--opcua", "TAKEN"], "--opcua takes another port"),
    ],
)
def test_where_it_may_not_listen(
    more: list[str], why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import socket

    with socket.create_server(("127.0.0.1", 0)) as taken:
        pem, key = pair(tmp_path, uri=STATION)
        words = {
            "PAIR": ["--certificate", str(pem), "--key", str(key)],
            "TAKEN": [str(taken.getsockname()[1])],
        }
        options = [part for one in more for part in words.get(one, [one])]
        call = ["station", "--product", "sim-disc", "--rig", "sim-line", "--no-listen"]
        assert run([*call, "-o", str(tmp_path / "shift"), *options]) == 2
    assert why in " ".join(capsys.readouterr().err.split())


def test_codes_of_units() -> None:
    """By the rule of OPC UA part 8: the characters of the common code, as bytes of a number."""
    assert (unit_id("°C"), unit_id("A"), unit_id("1")) == (4408652, 4279632, 4404786)
    assert unit_id("rpm/V") == NO_CODE
    assert all(code.isascii() and len(code) <= 3 for code in CODES.values())
