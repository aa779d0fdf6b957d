"""What each field of a product file may be, and what it is where it is left out."""

from __future__ import annotations

import hashlib
import math

import pytest

from motorid.errors import UsageError
from motorid.program import Decay, StepKind
from motorid.quality.guard_band import Rule
from motorid.quality.limits import Limit
from motorid.quality.product import Product, SelfTest, SerialRule, load_product, parse
from motorid.quality.temperature import Temperature

HEAD = "[motor]\nvoltage_v = 6\n"
STEP = '[[program.steps]]\nkind = "drive_volts"\nvolts = 4.0\nduration_s = 0.1\n'
END = "[limits.R_25]\nhigh = 2.8\n"


def product(more: str = "", motor: str = "", step: str = STEP, end: str = END) -> Product:
    return parse(f"{more}\n{HEAD}{motor}\n{step}{end}", "my.toml")


def refused(says: str, **parts: str) -> None:
    with pytest.raises(UsageError) as caught:
        product(**parts)
    assert says in str(caught.value)


def test_what_is_left_out() -> None:
    found = product()
    assert (found.name, found.title, found.voltage_v, found.model) == ("my", "my", 6.0, "six")
    assert (found.segments, found.commutations_per_turn, found.lost_samples) == (0, 0, 0)
    assert found.warm_up is found.serial is found.ambient is None
    assert found.temperature == Temperature()
    assert found.self_test == SelfTest() == SelfTest((), 50, 2)
    assert Rule() == Rule("uncertainty", 1.0, 2.0, 0.025, None, None)
    assert found.limits == {"R_25": Limit("R_25", "ohm", -math.inf, 2.8, Rule(), False, "", "")}
    assert found.digest == hashlib.sha256(found.text.encode()).hexdigest()
    assert found.cited == {"product": found.digest}
    (step,) = found.program.steps
    assert (step.kind, step.duration_s, step.level, step.decay) == (
        StepKind.DRIVE_VOLTS, 0.1, 4.0, Decay.SYNCHRONOUS_SLOW,
    )  # fmt: skip


def test_what_is_given() -> None:
    found = parse(
        'name = "P"\ntitle = "T"\n'
        + HEAD
        + 'segments = 5\n[capture]\nlost_samples = 7\n[decision]\nmodel = "better"\nr = 0.5\n'
        '[self_test]\ngolden = ["G1", "G2"]\ninspections = 9\ndead_in_a_row = 3\n'
        "[ambient]\nlow_c = 18\nhigh_c = 28\n[temperature]\nmagnet_per_k = -0.002\nrise_k = 4\n"
        '[[warm_up.steps]]\nkind = "coast"\nduration_s = 2\n'
        '[[program.steps]]\nkind = "drive_duty"\nduty = 0.5\nduration_s = 1\ndecay = "fast"\n'
        '[limits.K_25]\nlow = 1e-3\nlow_means = "weak"\nhigh_means = "strong"\nr = 0.7\n'
        '[limits."measured_speed@-3"]\nlow = 1\nhigh = 2\nunit = "rad/s"\n'
    )
    assert (found.name, found.title, found.model, found.lost_samples) == ("P", "T", "better", 7)
    assert (found.segments, found.commutations_per_turn) == (5, 10)
    assert found.self_test == SelfTest(("G1", "G2"), 9, 3)
    assert found.ambient is not None
    assert (found.ambient.low, found.ambient.high, found.ambient.condition) == (18.0, 28.0, True)
    assert (found.ambient.rule.name, found.ambient.unit) == ("simple", "°C")
    assert found.ambient.low_means == found.ambient.high_means != ""
    assert (found.temperature.magnet_per_k, found.temperature.rise_k) == (-0.002, 4.0)
    assert found.warm_up is not None
    assert (found.warm_up.steps[0].kind, found.warm_up.steps[0].duration_s) == (StepKind.COAST, 2.0)
    (step,) = found.program.steps
    assert (step.kind, step.level, step.decay.name) == (StepKind.DRIVE_DUTY, 0.5, "FAST")
    weak = found.limits["K_25"]
    assert (weak.low, weak.high, weak.low_means, weak.high_means) == (
        1e-3, math.inf, "weak", "strong",
    )  # fmt: skip
    assert (weak.rule.r, found.limits["measured_speed@-3"].rule.r) == (0.7, 0.5)


@pytest.mark.parametrize(("segments", "turns"), [(4, 4), (5, 10), (0, 0)])
def test_commutations_of_an_odd_commutator_are_twice_its_bars(segments: int, turns: int) -> None:
    assert product(motor=f"segments = {segments}").commutations_per_turn == turns
    other = product(motor=f"segments = {segments}\ncommutations_per_turn = 3")
    assert other.commutations_per_turn == 3


NUMBERS = [
    ("motor.segments", 0, 1000), ("motor.commutations_per_turn", 0, 1000),
    ("capture.lost_samples", 0, 1e9), ("self_test.inspections", 1, 100_000),
    ("self_test.dead_in_a_row", 1, 1000), ("temperature.rise_k", -200, 200),
    ("temperature.copper_per_k", -200, 200), ("limits.R_25.low", -1e12, 1e12),
    ("limits.R_25.r", 0, 10),
]  # fmt: skip


@pytest.mark.parametrize(("field", "least", "most"), NUMBERS)
def test_numbers_stay_within_reason(field: str, least: float, most: float) -> None:
    section, _, key = field.rpartition(".")

    def made(value: str) -> Product:
        if section == "motor":
            return product(motor=f"{key} = {value}")
        if section == "limits.R_25":
            return product(end=f"{END.replace('2.8', '1e12')}{key} = {value}\n")
        return product(more=f"[{section}]\n{key} = {value}")

    for value in (least - 1, 1.01 * most + 1, "true", '"1"', "nan"):
        text = str(value) if isinstance(value, str) else repr(value)
        with pytest.raises(UsageError) as caught:
            made(text)
        assert f"{field} must be a number from {least:g} to {most:g}, not" in str(caught.value)
    assert made(repr(least))
    if key != "low":  # of a tolerance nothing is left there
        assert made(repr(most))


@pytest.mark.parametrize(("end", "most"), [("high", 1e12), ("low", -1e12)])
def test_the_farthest_limits(end: str, most: float) -> None:
    limit = product(end=f"[limits.R_25]\n{end} = {most}\n").limits["R_25"]
    assert (limit.high if end == "high" else limit.low) == most
    refused(f"R_25.{end} must be a number from", end=f"[limits.R_25]\n{end} = {1.1 * most}\n")


@pytest.mark.parametrize("volts", [1e-3, 1e3])
def test_the_motors_voltage(volts: float) -> None:
    head = f"[motor]\nvoltage_v = {volts}\n{STEP}{END}"
    assert parse(head).voltage_v == volts
    for beyond in (0.99e-3, 1.01e3):
        with pytest.raises(UsageError, match=r"motor\.voltage_v must be a number from 0\.001"):
            parse(head.replace(str(volts), str(beyond)))


@pytest.mark.parametrize(
    ("low", "high", "says"),
    [
        (-100, 300, ""), (-101, 20, "ambient.low_c must be a number from -100 to 300"),
        (20, 301, "ambient.high_c must be a number from -100 to 300"),
        (20, 20, "must be below"), (None, 20, "ambient.low_c is missing"),
        (20, None, "ambient.high_c is missing"),
    ],
)  # fmt: skip
def test_an_ambient(low: float | None, high: float | None, says: str) -> None:
    ends = "".join(f"{n} = {x}\n" for n, x in (("low_c", low), ("high_c", high)) if x is not None)
    if says:
        refused(says, more=f"[ambient]\n{ends}")
    else:
        assert product(f"[ambient]\n{ends}").ambient is not None


@pytest.mark.parametrize(
    "section",
    ["", "motor", "capture", "decision", "self_test", "ambient", "temperature", "serial",
     "limits.R_25", "program"],
)  # fmt: skip
def test_an_unknown_key_is_refused_everywhere(section: str) -> None:
    key = "zzz = 1\n"
    if section == "motor":
        parts = {"motor": key}
    elif section == "limits.R_25":
        parts = {"end": END + key}
    elif section == "program":
        parts = {"step": "[program]\n" + key + STEP}
    else:
        parts = {"more": (f"[{section}]\n" if section else "") + key}
    refused(f"unknown key {section}.zzz".replace(" .", " "), **parts)


@pytest.mark.parametrize("name", ["motor", "capture", "program", "limits", "serial"])
def test_a_section_is_a_table(name: str) -> None:
    parts = {"motor": HEAD, "program": STEP, "limits": END}
    kept = "".join(text for key, text in parts.items() if key != name)
    with pytest.raises(UsageError, match=rf"\[{name}\] must be a table"):
        parse(f"{name} = 3\n{kept}")


@pytest.mark.parametrize(
    ("step", "says"),
    [
        ("", "[[program.steps]] must name 1 to 200 steps"),
        ("[program]\nsteps = []\n", "must name 1 to 200 steps"),
        ("[program]\nsteps = 3\n", "must name 1 to 200 steps"),
        (STEP * 201, "must name 1 to 200 steps"),
        ("[program]\nsteps = [3]\n", "program.steps[0] must be a table"),
        (STEP + STEP.replace("drive_volts", "drive"), "program.steps[1].kind must be one of"),
        (STEP.replace("volts = 4.0", "duty = 0.3"), "program.steps[0].volts is missing"),
        (STEP.replace("drive_volts", "drive_duty"), "program.steps[0].duty is missing"),
        (STEP.replace("drive_volts", "coast"), "unknown key program.steps[0] (coast).volts"),
        (STEP.replace("duration_s = 0.1", ""), "program.steps[0].duration_s is missing"),
        (STEP.replace("0.1", "0.9e-6"), "duration_s must be a number from 1e-06 to 1e+06"),
        (STEP.replace("0.1", "1.1e6"), "duration_s must be a number from 1e-06 to 1e+06"),
        (STEP.replace("4.0", "1001"), "volts must be a number from -1000 to 1000"),
        (STEP.replace("4.0", "-1001"), "volts must be a number from -1000 to 1000"),
        (STEP + 'decay = "quick"\n', "program.steps[0].decay must be one of"),
    ],
)
def test_steps_that_are_none(step: str, says: str) -> None:
    refused(says, step=step)


def test_steps_at_their_bounds() -> None:
    assert len(product(step=STEP * 200).program.steps) == 200
    for old, new in (("0.1", "1e-6"), ("4.0", "-4.0")):
        assert product(step=STEP.replace(old, new)).program.steps


@pytest.mark.parametrize(
    ("end", "says"),
    [
        ("", "[limits] is empty"), ("[limits]\nR_25 = 3\n", "limits.R_25 must be a table"),
        ("[limits.R_25]\n", "needs a low below its high, or one of them"),
        ("[limits.R_25]\nlow = 1\nhigh = 1\n", "needs a low below its high"),
        ("[limits.R_25]\nlow = 1\nunit = 3\n", "limits.R_25.unit must be a short text"),
        ("[limits.ripple_segment]\nhigh = 1\n", "limits.ripple_segment needs motor.segments"),
        ('[limits."measured_speed@"]\nhigh = 1\n', "there is no such quantity"),
        ("[limits.zzzzzzzz]\nhigh = 1\n", "measured_speed@VOLTS"),
        (END + 'rule = "global_risk"\nprocess_mean = 1\n', "needs process_mean and process_sd"),
        (END + 'rule = "global_risk"\nprocess_sd = 1\n', "needs process_mean and process_sd"),
    ],
)  # fmt: skip
def test_limits_that_are_none(end: str, says: str) -> None:
    refused(says, end=end)


def test_rules_at_their_fullest() -> None:
    text = END + (
        'rule = "global_risk"\nr = 2\ncoverage_factor = 3\nconsumer_risk = 0.01\n'
        "process_mean = 2.5\nprocess_sd = 0.1\n"
    )
    rule = product(end=text).limits["R_25"].rule
    assert rule == Rule("global_risk", 2.0, 3.0, 0.01, 2.5, 0.1)
    assert product(motor="segments = 2", end="[limits.ripple_turn]\nhigh = 1\n").segments == 2
    refused("needs motor.segments", motor="segments = 1", end="[limits.ripple_turn]\nhigh = 1\n")


@pytest.mark.parametrize(
    ("serial", "says"),
    [
        ("pattern = 'A'\nrepeat = 'never'", "serial.repeat must be one of count, refuse"),
        ("pattern = 'A*'", "no groups"), ("pattern = ''", "no groups"),
        (f"pattern = '{'A' * 201}'", "no groups"), ("pattern = '[z-a]'", "is no pattern"),
        ("pattern = 'A?B?C?D{1,2}'", "3 variable counts at most"),
        ("pattern = 'A{2}'\nexample = 'A'", "does not match"), ("pattern = 3", "a short text"),
        (f"pattern = 'A'\nexample = '{'A' * 1001}'", "a short text"),
    ],
)  # fmt: skip
def test_serial_rules_that_are_none(serial: str, says: str) -> None:
    if "[z-a]" in serial:
        serial += "\nexample = 'q'"
    refused(says, more=f"[serial]\n{serial}")


def test_serial_rules() -> None:
    most = "A" * 200
    for text, rule in (
        ("pattern = 'A?B?C{1,2}'", SerialRule("A?B?C{1,2}")),
        (f"pattern = '{most}'", SerialRule(most)),
        ("pattern = 'A{2}'\nexample = 'AA'\nrepeat = 'refuse'", SerialRule("A{2}", "AA", "refuse")),
    ):
        assert product(f"[serial]\n{text}").serial == rule
    assert SerialRule("A").repeat == "count"


def test_what_a_serial_rule_says() -> None:
    rule = SerialRule(r"\d{1,64}\d?", "12")
    assert rule.problem("1" * 64) == ""
    assert rule.problem("1" * 65).startswith(repr("1" * 64))
    assert rule.problem("") == (
        "nothing is no serial number of this product, such as 12: scan the label again"
    )
    assert rule.problem("١").startswith("'١' is no")  # a digit, but not one of ASCII
    assert SerialRule("A").problem("B") == (
        "'B' is no serial number of this product: scan the label again"
    )


@pytest.mark.parametrize("golden", ["3", '[""]', "[3]", '"G"'])
def test_golden_motors_are_a_list_of_serial_numbers(golden: str) -> None:
    refused("self_test.golden must be a list", more=f"[self_test]\ngolden = {golden}")


@pytest.mark.parametrize("name", ["name", "title"])
def test_texts_are_short(name: str) -> None:
    assert product(f'{name} = "{"x" * 1000}"')
    refused(f"my.toml: {name} must be a short text", more=f'{name} = "{"x" * 1001}"')
    refused(f"my.toml: {name} must be a short text", more=f"{name} = 3")


@pytest.mark.parametrize("name", ["my\0name", "zzzzzzzz"])
def test_a_product_that_is_not_there(name: str) -> None:
    with pytest.raises(UsageError, match=r"no product file .*; products are .*sim-disc"):
        load_product(name)
