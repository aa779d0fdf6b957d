"""The specification: what it must not say, what is derived from it, and the hashes."""

from __future__ import annotations

import re
import subprocess
import sys
import zlib
from pathlib import Path

import pytest

from motorid.wire import enums, generate, hashes, render_c, render_enums
from motorid.wire.spec import PATH, SpecError, load, parse

TEXT = PATH.read_text(encoding="utf-8")
SPEC = load()


def changed(old: str, new: str) -> str:
    """The specification's text with its first ``old`` replaced."""
    assert old in TEXT
    return TEXT.replace(old, new, 1)


def test_load_is_cached_and_frozen() -> None:
    assert load() is load()
    with pytest.raises(AttributeError):
        SPEC.major = 2  # type: ignore[misc]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("[protocol]", "[protocol", "does not read"),
        ("baud = 1000000\n", "", "baud"),
        ("code = 0x02", "code = 0x01", "describe_channel has the code of identify"),
        ("code = 0x0C", "code = 0x50", "clear_fault has a code outside its range: 0x50"),
        ("code = 0x0C", "code = 0x00", "clear_fault has a code outside its range: 0x00"),
        ("code = 0x44", "code = 0x04", "hello has the code of read_config"),
        ('["host_minor", "u8"', '["host_major", "u8"', "identify names a field twice"),
        ('["host_minor", "u8"', '["host_minor", "u64"', "unknown type u64"),
        ('"enum mode"', '"enum mood"', "describe_channel.mode names the unknown enum mood"),
        ('["host_minor", "u8"', '["host_minor", "text16"', None),
        ("max_command = 64", "max_command = 31", "configure has 50 bytes of fields"),
        ("max_payload = 240", "max_payload = 60", "identify reply has 82 bytes"),
        ("max_payload = 240", "max_payload = 252", "one COBS group"),
        ("fault_latched = 7", "fault_latched = 6", "enum status repeats a value"),
        ("fault_latched = 7", "fault_latched = 256", "leaves 0 to 255"),
        ('states = ["loaded"]', 'states = ["ready"]', "start names unknown states"),
        ('ok = "done', 'okay = "done', "must explain each value of .enum.status"),
        ('speaks"]', 'speaks", 4]', "newer than minor 3"),
    ],
)
def test_contradictions_are_named(old: str, new: str, complaint: str | None) -> None:
    if complaint is None:  # a change that is none: the check is not trigger-happy
        assert parse(changed(old, new)).commands["identify"].fields[1].type == "text16"
        return
    with pytest.raises(SpecError, match=complaint):
        parse(changed(old, new))


def with_minor_4(order: str) -> str:
    return changed("minor = 3", "minor = 4").replace(
        '["samples", "u16", "", "readings to average (1 to 4096)"]', order, 1
    )


def test_an_appended_field_comes_last_and_not_before_a_tail() -> None:
    good = parse(with_minor_4('["samples", "u16", "", ""], ["more", "u32", "", "", 4]'))
    assert good.commands["zero"].fields[1].since == 4
    with pytest.raises(SpecError, match="appended field before an older one"):
        parse(with_minor_4('["more", "u32", "", "", 4], ["samples", "u16", "", ""]'))
    text = changed("minor = 3", "minor = 4").replace(
        '"samples in the block"]', '"samples in the block", 4]', 1
    )
    with pytest.raises(SpecError, match="has a tail"):
        parse(text)


def test_importing_the_specification_stays_light() -> None:
    code = (
        "import sys; import motorid.wire.spec as s, motorid.wire.framing, motorid.wire.hashes;"
        "s.load(); print([m for m in ('numpy', 'scipy', 'serial') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=generate.ROOT
    )
    assert done.stdout.strip() == "[]"


# ---------------------------------------------------------------- derived files


def test_derived_files_are_not_stale(capsys: pytest.CaptureFixture[str]) -> None:
    assert generate.main(["--check"]) == 0, capsys.readouterr().err


def test_check_names_the_stale_file_and_write_mends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(generate, "ROOT", tmp_path)
    assert generate.main(["--check"]) == 2  # no source tree
    (tmp_path / "pyproject.toml").touch()
    assert generate.main([]) == 0
    assert generate.main(["--check"]) == 0
    header = tmp_path / "firmware/core/wire_gen.h"
    header.write_text(header.read_text(encoding="utf-8").replace("0x29B1u", "0x29B2u"))
    capsys.readouterr()
    assert generate.main(["--check"]) == 1
    assert capsys.readouterr().err.startswith("firmware/core/wire_gen.h is stale")
    header.unlink()
    assert generate.main(["--check"]) == 1
    assert generate.main([]) == 0
    assert "0x29B1u" in header.read_text(encoding="utf-8")


def test_page_names_every_message_field_and_value() -> None:
    page = (generate.ROOT / "docs/protocol.md").read_text(encoding="utf-8")
    assert "{{" not in page
    for message in [*SPEC.commands.values(), *SPEC.events.values()]:
        assert f"### {message.name} (0x{message.code:02X})" in page
        for field in message.fields + message.reply:
            assert f"`{field.name}`" in page
    for values in SPEC.enums.values():
        assert all(f"| {value} | `{name}` |" in page for name, value in values.items())


def test_page_links_to_headings_that_exist() -> None:
    page = (generate.ROOT / "docs/protocol.md").read_text(encoding="utf-8")
    headings = set(re.findall(r"^#+ (\w+)$", page, re.MULTILINE))
    assert set(re.findall(r"\]\(#(\w+)\)", page)) <= headings


def test_enums_are_the_specifications() -> None:
    for name, values in SPEC.enums.items():
        members = getattr(enums, render_enums.class_name(name)).__members__
        assert {key.lower(): int(member) for key, member in members.items()} == dict(values)


# ---------------------------------------------------------------- hashes

CONFIG = {
    "sample_period_ticks": 8000,
    "channels": 0b1011,
    "mode": 0,
    "encoder_reversed": 1,
    "current_limit_ma": 2500,
    "speed_limit_counts_s": 300_000,
    "supply_min_mv": 9000,
    "supply_max_mv": 14_000,
    "run_time_limit_ms": 60_000,
    "host_silence_ms": 500,
}
NEW = {
    "voltage_limit_mv": 12_000,
    "inputs_required": 3,
    "sign_check_ms": 20,
    "sign_check_ma": 400,
    "sign_check_mv": 1500,
    "sign_check_counts": 40,
    "front_end_hash": 0xDEADBEEF,
}
STEP = {"index": 0, "kind": 1, "decay": 2, "level": -500_000, "ticks": 80_000}


def test_config_hash_is_that_of_the_bytes_written_out_by_hand() -> None:
    wire = bytes.fromhex(
        "401f0000 0b 00 01 c4090000 e0930400 28230000 b0360000 60ea0000 f401".replace(" ", "")
    )
    for minor in (0, 1, 2):
        assert hashes.config_hash(CONFIG | NEW, minor) == zlib.crc32(wire)
    assert hashes.config_hash({**CONFIG, "config_hash": 1}, 2) == zlib.crc32(wire)
    new = bytes.fromhex("e02e0000 03 1400 90010000 dc050000 2800 efbeadde".replace(" ", ""))
    assert hashes.config_hash(CONFIG | NEW) == zlib.crc32(wire + new)
    assert hashes.config_hash(CONFIG | NEW, SPEC.minor + 1) == zlib.crc32(wire + new)
    assert hashes.config_hash(CONFIG) == zlib.crc32(wire + bytes(len(new)))


@pytest.mark.parametrize("name", [*CONFIG, *NEW])
def test_config_hash_sees_every_field(name: str) -> None:
    whole = CONFIG | NEW
    assert hashes.config_hash({**whole, name: whole[name] ^ 1}) != hashes.config_hash(whole)
    if name in NEW:  # absent is 0
        return
    with pytest.raises(ValueError, match=name):
        hashes.config_hash({key: value for key, value in CONFIG.items() if key != name})


def test_program_hash_is_that_of_the_bytes_and_sees_order() -> None:
    first = bytes.fromhex("00 01 02 e05ef8ff 80380100".replace(" ", ""))
    second = bytes.fromhex("01 00 00 00000000 80380100".replace(" ", ""))
    coast = {"index": 1, "kind": 0, "decay": 0, "level": 0, "ticks": 80_000}
    assert hashes.program_hash([]) == 0
    assert hashes.program_hash([STEP]) == zlib.crc32(first)
    assert hashes.program_hash([STEP, coast]) == zlib.crc32(second, zlib.crc32(first))
    assert hashes.program_hash([coast, STEP]) != hashes.program_hash([STEP, coast])


def test_layout_hash_sees_layout_and_not_explanations() -> None:
    same = parse(changed("latched fault, or none", "the latched fault"))
    assert hashes.layout_hash_of(same) == hashes.layout_hash()
    for old, new in [
        ('["host_minor", "u8"', '["host_minor", "u16"'),
        ('["host_minor", "u8"', '["host_small", "u8"'),
        (
            '"u32", "mV", "trip when the supply is below',
            '"u32", "V", "trip when the supply is below',
        ),
        ("over_speed = 2", "over_speed = 22"),
        ("code = 0x44", "code = 0x45"),
    ]:
        assert hashes.layout_hash_of(parse(changed(old, new))) != hashes.layout_hash()
    header = render_c.render(SPEC)
    assert f"#define WIRE_LAYOUT_HASH 0x{hashes.layout_hash():08X}ul\n" in header
