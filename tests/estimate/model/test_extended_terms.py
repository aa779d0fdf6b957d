"""Parameters of wider models: what their figures are counted in."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.errors import UsageError
from motorid.estimate.model.extended_terms import ADDED, TERMS, Scales, Term, parse, unknown

SIZES = Scales(
    volts=12.0, current=3.0, speed=400.0, torque=0.02, resistance=4.0, inertia=1e-6,
    inductance=2e-4, duration=0.5,
)  # fmt: skip
KILO, METRE, SECOND, AMPERE, KELVIN = 3.0, 5.0, 7.0, 11.0, 1.0  # other sizes of the base units
VOLT = KILO * METRE**2 / SECOND**3 / AMPERE
UNITS = {
    "1": 1.0, "rad": 1.0, "V": VOLT, "A": AMPERE, "s": SECOND, "s²": SECOND**2, "rad²": 1.0,
    "N": KILO * METRE / SECOND**2, "m": METRE, "K": KELVIN, "J": KILO * METRE**2 / SECOND**2,
    "ohm": VOLT / AMPERE,
}  # fmt: skip


def factor(unit: str) -> float:
    """By which a figure in that unit grows with smaller base units: products over products."""
    above, *below = unit.split("/")
    out = 1.0
    for one in above.split("·"):
        out *= UNITS[one]
    for part in below:
        for one in part.split("·"):
            out /= UNITS[one]
    return out


@pytest.mark.parametrize("name", ADDED)
def test_a_search_counts_a_parameter_in_its_own_unit(name: str) -> None:
    """With other base units its size is the same one: the unit and the size go together."""
    others = replace(
        SIZES,
        volts=SIZES.volts * VOLT,
        current=SIZES.current * AMPERE,
        speed=SIZES.speed / SECOND,
        torque=SIZES.torque * factor("N·m"),
        resistance=SIZES.resistance * VOLT / AMPERE,
        inertia=SIZES.inertia * KILO * METRE**2,
        inductance=SIZES.inductance * VOLT * SECOND / AMPERE,
        duration=SIZES.duration * SECOND,
    )
    assert others.of(name) == pytest.approx(SIZES.of(name) * factor(ADDED[name].unit))
    assert " " in ADDED[name].meaning  # words


def test_a_term_is_nothing_where_its_parameters_are_absent() -> None:
    for term in TERMS.values():
        assert [ADDED[name].absent for name in term.sizes] == [0.0] * len(term.sizes)


def test_a_motor_without_inductance_has_a_rise_all_the_same() -> None:
    assert replace(SIZES, inductance=0.0).rise > 0.0
    assert SIZES.rise == pytest.approx(SIZES.inductance / SIZES.resistance)


def test_a_search_begins_within_the_bounds_of_what_it_adds() -> None:
    for name, added in ADDED.items():
        start = added.part * SIZES.of(name)
        assert added.lower <= start <= added.upper, name
        if added.log:
            assert start > 0.0, name


def test_bounds_keep_a_motor_a_motor() -> None:
    """A back-EMF of its own sign, an inductance and a share that are left, friction that brakes."""
    assert -1.0 < ADDED["d_Ke"].lower < 0.0
    assert 0.0 < ADDED["J2_share"].lower < ADDED["J2_share"].upper < 1.0
    for share in ("d_L", "L2_share", "c_load"):
        assert ADDED[share].lower == 0.0
        assert 0.5 < ADDED[share].upper < 1.0
    for share in ("d_T0", "k_R"):  # of a friction, or of a resistance: what is left is one
        assert (ADDED[share].lower, ADDED[share].upper) == (-1.0, 1.0)
    for size in ("V_b", "T_lc", "T_s", "T_c", "k_K", "Ks", "b", "a_K", "k_w", "c_R"):
        assert ADDED[size].lower == 0.0


def test_what_is_positive_and_may_be_of_any_size_is_searched_by_its_logarithm() -> None:
    """Where a term bends, and how stiff a shaft is. A size may be nothing, without a logarithm; so
    may the speed from which R rises, and the rate at which friction changes.
    """
    bends = {name for term in TERMS.values() for name in term.shapes} - {"w_R", "r_f"}
    assert {name for name, added in ADDED.items() if added.log} == {*bends, "Ks"}
    assert ADDED["w_R"].lower == min(TERMS["commutation-resistance"].shapes["w_R"]) == 0.0
    assert ADDED["r_f"].lower == min(TERMS["friction-drift"].shapes["r_f"]) == 0.0
    assert not any(ADDED[name].log for term in TERMS.values() for name in term.sizes)


def test_an_unknown_is_searched_as_its_parameter_is_described() -> None:
    for name, added in ADDED.items():
        made = unknown(name, 0.5, SIZES, None)
        assert (made.name, made.start, made.log) == (name, 0.5, added.log)
        assert (made.lower, made.upper) == (added.lower, added.upper)
        assert made.scale == pytest.approx(SIZES.of(name))
        assert (made.prior_mean, made.prior_sd) == (0.0, float("inf"))
    known = unknown("i_b", 0.5, SIZES, (-3.0, 0.7))
    assert (known.prior_mean, known.prior_sd) == (-3.0, 0.7)


def test_terms_are_named_once_each_and_others_are_refused_with_the_nearest() -> None:
    assert parse("eddy+cogging+eddy") == (TERMS["eddy"], TERMS["cogging"])
    with pytest.raises(UsageError, match=r'no model "coging".*cogging'):
        parse("eddy+coging")


def test_a_phase_is_of_the_terms_that_turn_with_the_rotor() -> None:
    for term in TERMS.values():
        phased = term.phased(0.7)
        assert list(phased.values()) == ([0.7] if term.phase else [])
        assert bool(term.per_turn) <= bool(term.phase)
    assert TERMS["ripple"].sizes == ("k_K", "k_R")
    assert TERMS["brush-drop"].sizes == ("V_b",)


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("d_Ke", 1.0), ("V_b", 12.0), ("i_b", 3.0), ("a_K", 1.0 / 3.0), ("w_s", 400.0),
        ("t_e", 2e-4 / 4.0), ("T_s", 0.02), ("k_w", 1.0 / 0.5), ("c_R", 4.0 / 400.0),
    ],
)  # fmt: skip
def test_a_size_is_that_of_the_captures(name: str, size: float) -> None:
    assert SIZES.of(name) == pytest.approx(size)


def test_sizes_of_several_units_are_what_a_motor_would_show() -> None:
    """The torque at full speed; a shaft that swings at a tenth of it, and is damped over the run;
    a winding whose resistance the heat of the run, all kept, would double.
    """
    assert SIZES.of("T_lc") * SIZES.speed**2 == pytest.approx(SIZES.torque)
    assert (SIZES.of("Ks") / SIZES.inertia) ** 0.5 == pytest.approx(SIZES.speed / 10.0)
    assert SIZES.of("b") / SIZES.inertia * SIZES.duration == pytest.approx(1.0)
    heat = SIZES.resistance * SIZES.current**2 * SIZES.duration
    assert 0.00393 * heat * SIZES.of("per_C_w") == pytest.approx(1.0)
    assert replace(SIZES, inductance=0.0).of("t_e") == pytest.approx(1e-3)


@pytest.mark.parametrize("term", TERMS.values(), ids=list(TERMS))
def test_an_equation_has_the_parameters_of_its_term_and_a_title_is_words(term: Term) -> None:
    written = [name.removeprefix("per_").removesuffix("_share") for name in term.free]
    assert all(symbol in term.equation for symbol in written)
    assert not set(written) & set(term.title.split())
    assert not set("=()²×") & set(term.title)
    assert term.size in term.free
    assert set(term.shapes) <= set(term.free) - {term.size}


@pytest.mark.parametrize("term", TERMS.values(), ids=list(TERMS))
def test_bends_are_tried_within_what_the_captures_show(term: Term) -> None:
    """Currents below stall and speeds below the highest; times about that of the winding. What is
    no logarithm may begin at its bound.
    """
    for name, parts in term.shapes.items():
        longest = 10.0 if ADDED[name].scale in ("L/R", "1/s") else 1.0
        assert list(parts) == sorted(set(parts))
        least = 0.0 if ADDED[name].log else -1e-9
        assert least < parts[0] < parts[-1] < longest
        assert parts[0] >= ADDED[name].lower
