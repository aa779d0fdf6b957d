"""A station at Debian's mosquitto: state, verdicts until they are acknowledged, and outages."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid import json_seal, json_text
from motorid.report.screen import Screen
from motorid.workflow.check import VERDICT, Inspection
from motorid.workflow.mqtt import outbox
from motorid.workflow.mqtt.outbox import MARK, Outbox
from motorid.workflow.mqtt.settings import PASSWORD, Broker, read_broker
from motorid.workflow.mqtt.witness import MqttWitness
from tests.certificates import pair
from tests.plant.consumer import consuming, valid, wait_for
from tests.plant.mosquitto import ABSENT, PROGRAM, Mosquitto, broker
from tests.quality.controller import Controller
from tests.quality.test_station import running

needs_mosquitto = pytest.mark.skipif(PROGRAM is None, reason=ABSENT)
PAGE = Path(__file__).parents[2] / "docs" / "mqtt.md"
STATE = {"serial": "", "product": "sim-disc", "unacknowledged": 0}


def inspected(folder: Path, number: int) -> Path:
    """An inspection's folder with its verdict, as a station leaves it."""
    made = folder / f"D{number:06d}_20260101T080000"
    made.mkdir(parents=True)
    stored = {
        "schema": "motorid-verdict-1", "time": "2026-01-01T08:00:00.000+00:00", "product": "m17",
        "serial": f"D{number:06d}", "outcome": "PASS", "marginal": False, "reasons": [],
        "measurements": [], "inputs": [], "versions": {"motorid": "0", "product": "0" * 64},
    }  # fmt: skip
    (made / VERDICT).write_text(json_text.dumps(json_seal.sealed(stored)))
    return made


class Here:
    """A witness at a broker, and what a person was told."""

    def __init__(self, port: int, folder: Path, **more: Any) -> None:
        self.told: list[str] = []
        settings = {"acknowledged": True, "repeat_s": 1.0, **more}
        place = Broker("127.0.0.1", port, False, "motorid", **settings)
        folder.mkdir(exist_ok=True)
        self.witness = MqttWitness(place, "line-1", "sim-disc", folder)

    def show(self, word: str, serial: str = "") -> None:
        self.witness.shown(Screen(word, (), "", serial=serial))

    def judge(self, folder: Path) -> None:
        self.witness.judged(Inspection(None, folder, 0))  # type: ignore[arg-type]

    @property
    def open(self) -> int:
        return int(self.witness.status()["mqtt"]["unacknowledged"])


@contextlib.contextmanager
def at(port: int, folder: Path, **more: Any) -> Iterator[Here]:
    here = Here(port, folder, **more)
    with here.witness.running(here.told.append):
        yield here


def marked(folder: Path) -> int:
    return sum(1 for _ in folder.glob(f"*/{MARK}"))


@pytest.mark.slow
@needs_mosquitto
def test_state_is_retained_and_verdicts_come_once(tmp_path: Path) -> None:
    with broker(tmp_path) as mosquitto, at(mosquitto.port, tmp_path / "shift") as here:
        here.show("READY")
        wait_for(lambda: here.witness._stated)
        with consuming(mosquitto.port) as late:  # it gets what is retained
            wait_for(lambda: late.states)
            assert late.states[0] | STATE == late.states[0]
            assert late.states[0]["state"] == "READY"
            here.show("RUN", "D000001")
            wait_for(lambda: late.states[-1]["state"] == "RUN")
            assert late.states[-1]["serial"] == "D000001"
            here.judge(inspected(tmp_path / "shift", 1))
            wait_for(lambda: marked(tmp_path / "shift") == 1)
            (stored,) = late.verdicts.values()
            assert stored["serial"] == "D000001"
            assert here.told == []


@pytest.mark.slow
@needs_mosquitto
def test_the_last_will_and_the_last_word(tmp_path: Path) -> None:
    with broker(tmp_path) as mosquitto, consuming(mosquitto.port) as consumer:
        with at(mosquitto.port, tmp_path / "shift") as here:
            here.show("READY")
            wait_for(lambda: consumer.states)
        wait_for(lambda: consumer.states[-1]["state"] == "OFFLINE")  # a shift that ended
        with at(mosquitto.port, tmp_path / "shift") as here:
            here.show("READY")
            wait_for(lambda: consumer.states[-1]["state"] == "READY")
            link = here.witness._client.socket()
            assert link is not None
            here.witness._client.reconnect_delay_set(60, 60)
            link.shutdown(2)  # as when the cable is pulled: the broker says the will
            wait_for(lambda: consumer.states[-1]["state"] == "OFFLINE")


@needs_mosquitto
@pytest.mark.slow
def test_a_broker_that_dies_loses_nothing(tmp_path: Path) -> None:
    """1,300 verdicts, more than mosquitto queues; it is killed with what it holds, twice."""
    shift, count = tmp_path / "shift", 1300
    folders = [inspected(shift, number) for number in range(count)]
    with broker(tmp_path) as mosquitto, at(mosquitto.port, shift) as here:
        with consuming(mosquitto.port) as consumer:
            wait_for(lambda: len(consumer.verdicts) > 100)
            mosquitto.kill()
            wait_for(lambda: here.told)
            mosquitto.start()
            wait_for(lambda: len(consumer.verdicts) > 500)
        assert here.open > outbox.MOST_OPEN
        mosquitto.kill()
        mosquitto.start()
        with consuming(mosquitto.port) as again:
            wait_for(lambda: marked(shift) == count)
    got = {one["serial"] for one in (consumer.verdicts | again.verdicts).values()}
    assert len(got) == count == len(folders)
    assert "connection" in here.told[0]


@needs_mosquitto
@pytest.mark.slow
def test_without_an_acknowledgement_a_verdict_is_sent_again(tmp_path: Path) -> None:
    """And by the next shift as well, if the station was killed."""
    with broker(tmp_path) as mosquitto, consuming(mosquitto.port, acknowledges=False) as deaf:
        with at(mosquitto.port, tmp_path / "shift") as here:
            here.judge(inspected(tmp_path / "shift", 1))
            wait_for(lambda: len(deaf.came) >= 2)
            assert here.open == 1
        times = len(deaf.came)
        with at(mosquitto.port, tmp_path / "shift"):
            wait_for(lambda: len(deaf.came) > times)
            (key,) = Counter(deaf.came)
            deaf.acknowledge("motorid/line-1/verdict", "0" * 64)  # of nobody
            deaf.acknowledge("motorid/line-1/verdict", key)
            wait_for(lambda: marked(tmp_path / "shift") == 1)


@pytest.mark.slow
@needs_mosquitto
def test_without_a_consumer_the_brokers_word_counts_and_that_is_said(tmp_path: Path) -> None:
    shift = tmp_path / "shift"
    with broker(tmp_path) as mosquitto, at(mosquitto.port, shift, acknowledged=False) as here:
        here.judge(inspected(shift, 1))
        wait_for(lambda: marked(shift) == 1)
        assert "no consumer acknowledges verdicts" in here.told[0]


@needs_mosquitto
@pytest.mark.slow
def test_a_broker_that_hangs_holds_nobody_up(tmp_path: Path) -> None:
    shift = tmp_path / "shift"
    with (
        broker(tmp_path) as mosquitto,
        at(mosquitto.port, shift) as here,
        consuming(mosquitto.port) as consumer,
    ):
        here.show("READY")
        wait_for(lambda: here.witness._stated)
        mosquitto.signal(signal.SIGSTOP)
        for number in range(300):  # each returns, whatever the broker does
            here.show("RUN", f"D{number:06d}")
            here.judge(inspected(shift, number))
        wait_for(lambda: here.open == 300)
        mosquitto.signal(signal.SIGCONT)
        wait_for(lambda: marked(shift) == 300)
        assert len(consumer.verdicts) == 300


@pytest.fixture
def locked(tmp_path: Path) -> Iterator[tuple[Mosquitto, Path]]:
    """A broker with TLS, a user and no anonymous clients; and its certificate."""
    pem, key = pair(tmp_path)
    passwords = tmp_path / "passwords"
    passwords.touch(mode=0o600)
    words = ["mosquitto_passwd", "-b", str(passwords), "line", "right"]
    subprocess.run(words, check=True, capture_output=True)
    lines = [f"certfile {pem}", f"keyfile {key}", "allow_anonymous false"]
    with broker(tmp_path, *lines, f"password_file {passwords}") as mosquitto:
        yield mosquitto, pem


@pytest.mark.slow
@needs_mosquitto
@pytest.mark.parametrize("password", ["right", "wrong"])
def test_tls_and_password(password: str, locked: tuple[Mosquitto, Path], tmp_path: Path) -> None:
    mosquitto, pem = locked
    (tmp_path / "secret").write_text(f"{password}\n")
    said = tmp_path / "mqtt.toml"
    said.write_text(
        f'url = "mqtts://localhost:{mosquitto.port}"\nuser = "line"\n'
        f'password_file = "secret"\nca_file = "{pem.name}"\n'
    )
    place = read_broker(said)
    assert "password='" not in repr(place)
    told: list[str] = []
    shift = tmp_path / "shift"
    folder = inspected(shift, 1)
    witness = MqttWitness(place, "line-1", "sim-disc", shift)
    with witness.running(told.append):
        if password == "right":
            wait_for(lambda: (folder / MARK).exists())
        else:
            wait_for(lambda: "Not authorized" in witness.trouble)
            assert "Not authorized" in told[-1]
            assert not (folder / MARK).exists()


@pytest.mark.slow
@needs_mosquitto
def test_a_broker_of_a_foreign_certificate_is_refused(
    locked: tuple[Mosquitto, Path], tmp_path: Path
) -> None:
    """The certificate is not of the system's authorities, and no ca_file names it."""
    place = Broker("localhost", locked[0].port, True, "motorid", "line", "right")
    told: list[str] = []
    (tmp_path / "shift").mkdir()
    with MqttWitness(place, "line-1", "sim-disc", tmp_path / "shift").running(told.append):
        wait_for(lambda: any("no connection can be made" in one for one in told))


@needs_mosquitto
@pytest.mark.slow
def test_a_station_that_is_killed_sends_what_it_had_not(tmp_path: Path) -> None:
    """Its broker was away; the next shift finds one."""
    mosquitto, shift = Mosquitto(tmp_path), tmp_path / "shift"
    said = tmp_path / "mqtt.toml"
    said.write_text(f'url = "mqtt://127.0.0.1:{mosquitto.port}"\nacknowledged = true\n')
    options = ("--station", "line-1", "--mqtt", str(said), "--history", str(tmp_path / "line.db"))
    with running(shift, *options) as (_, port):
        controller = Controller(port)
        controller.ask(order="inspect", serial="D000001")
        told = controller.hear()
        assert told["outcome"] == "PASS"
        valid(told, "order-answer")
        for order in ("status", "last", "history"):
            valid(controller.ask(order=order, serial="D000001"), "order-answer")
        wait_for(lambda: controller.ask(order="status")["mqtt"]["unacknowledged"] == 1)
        assert controller.ask(order="status")["mqtt"]["trouble"]
    mosquitto.start()  # the station was killed
    try:
        with consuming(mosquitto.port) as consumer, running(shift, *options):
            wait_for(lambda: marked(shift) == 1)
            (stored,) = consumer.verdicts.values()
            assert stored == json.loads((Path(told["folder"]) / VERDICT).read_text())
            wait_for(lambda: "READY" in [one["state"] for one in consumer.states])
        (state,) = {one["station"] for one in consumer.states}
        assert state == "line-1"
    finally:
        mosquitto.kill()


@pytest.mark.slow
@needs_mosquitto
def test_the_example_for_a_consumer_runs(tmp_path: Path) -> None:
    """The page's own program, as a reader would copy it."""
    (program,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    (tmp_path / "consumer.py").write_text(program, encoding="utf-8")
    with broker(tmp_path) as mosquitto, at(mosquitto.port, tmp_path / "shift") as here:
        here.judge(inspected(tmp_path / "shift", 1))
        words = [sys.executable, str(tmp_path / "consumer.py"), str(mosquitto.port)]
        consumer = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        try:
            assert consumer.stdout is not None
            assert consumer.stdout.readline() == "line-1 D000001 PASS\n"
            wait_for(lambda: marked(tmp_path / "shift") == 1)
        finally:
            consumer.kill()
            consumer.communicate()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('url = "http://x"', "url must be mqtts://"),
        ('url = "mqtt://10.0.0.1"', "anybody could read"),
        ('url = "mqtts://me:secret@broker"', "holds no user and no password"),
        ('url = "mqtts://broker:99999"', "url: "),
        ('url = "mqtts://broker"\ntopic = "a/#"', "without + and #"),
        ('url = "mqtts://broker"\nuser = "me"', "user has no password"),
        ('url = "mqtts://broker"\nrepeat_s = 0', "repeat_s must be"),
        ('url = "mqtts://broker"\nacknowledged = 1', "must be true or false"),
        ('url = "mqtts://broker"\nuser = "me"\npassword_file = "none"', "none"),
        ("", "url is missing"),
        ('uri = "x"', "the nearest is u"),
    ],
)
def test_settings_that_are_none(
    text: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motorid.errors import UsageError

    monkeypatch.delenv(PASSWORD, raising=False)
    path = tmp_path / "mqtt.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=re.escape(why)):
        read_broker(path)


def test_settings_that_are_some(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PASSWORD, "of the environment")
    path = tmp_path / "mqtt.toml"
    path.write_text('url = "mqtts://broker"\nuser = "me"\ntopic = "plant/motors"\n')
    found = read_broker(path)
    assert (found.host, found.port, found.tls) == ("broker", 8883, True)
    assert found.password == "of the environment"
    path.write_text('url = "mqtt://10.0.0.1"\nplain = true')
    assert read_broker(path).port == 1883


@pytest.mark.parametrize("name", ["", "a/b", "a+", "#"])
def test_a_station_without_a_name_for_topics(name: str, tmp_path: Path) -> None:
    from motorid.errors import UsageError

    with pytest.raises(UsageError, match="give it a name of its own"):
        MqttWitness(Broker("127.0.0.1", 1, False, "motorid"), name, "p", tmp_path)


def test_repetitions_come_later_and_later_and_never_too_many_at_once(tmp_path: Path) -> None:
    box = Outbox(tmp_path, 10.0)
    for number in range(2 * outbox.MOST_OPEN):
        inspected(tmp_path, number)
    box.find()
    while (folder := box.next()) is not None:
        box.sent(folder.name, folder, 0.0)
    assert len(box) == 2 * outbox.MOST_OPEN
    times = [now for now in range(2000) if "D000000_20260101T080000" in box.due(float(now))]
    assert times == [10, 30, 70, 150, 310, 610, 910, 1210, 1510, 1810]
    box.acknowledged("D000000_20260101T080000")
    assert box.next() == tmp_path / f"D{outbox.MOST_OPEN:06d}_20260101T080000"
    box.add(tmp_path / "D000000_20260101T080000")  # it is done
    assert len(box) == 2 * outbox.MOST_OPEN - 1
    assert json.dumps(sorted(box.due(1e9))) == json.dumps(sorted(box.due(2e9)))
