"""What in the review's tables cannot be right, with the arithmetic that shows it.

Every number in these sentences is computed here from the printed figures and the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from motorid.motor.batch import LINEAR, Record, blank
from motorid.search.relations import inertia, step_facts
from motorid.search.review.speed_only import speed_twin
from motorid.search.review.tables import PERCENT_ORDER, printed, table


def no_load_speed(values: Mapping[str, float]) -> float:
    """rad/s per V of the linear motor, unloaded."""
    return values["K"] / (values["K"] ** 2 + values["R"] * values["B"])


def off(figure: float, nominal: float) -> float:
    """Signed error in percent of the nominal value."""
    return 100.0 * (figure / nominal - 1.0)


def speed_mse(values: Mapping[str, float], truth: Mapping[str, float]) -> float:
    """Mean square difference of the speeds of two motors in Table 6's experiment, (rad/s)²."""
    experiment = table(6)[0]
    record = Record(experiment.period_s, experiment.input, blank(experiment.input, ("speed",)))
    both = np.array([[m[name] for name in LINEAR.parameters] for m in (values, truth)])
    speeds = LINEAR.outputs(both, record)[:, 0]
    return float(np.mean((speeds[0] - speeds[1]) ** 2))


def printed_rule_bias(number: int) -> float:
    """J by the printed rule against the nominal J, with K exact: percent of the estimate."""
    experiment = table(number)[0]
    facts = step_facts(experiment.problem(0.0, 0).step, experiment.problem(0.0, 0).acceleration)
    J = float(inertia(facts, "printed", np.array([experiment.truth["K"]]))[0])
    return 100.0 * (J - experiment.truth["J"]) / J


def tied_r(k_percent: float, a: float, sign: float) -> float:
    """R% that (26) and (27) force on a row with that K%, both relative to the estimate."""
    d = 1.0 / (1.0 - sign * k_percent / 100.0) - 1.0  # K_est/K_nom - 1
    return float(100.0 * abs(1.0 - 1.0 / (1.0 - a * d)))


def remarks(number: int) -> tuple[str, ...]:
    """Sentences on one table's figures."""
    return _SENTENCES[number]()


def _table_2() -> tuple[str, ...]:
    figures = printed()["table2"]
    speeds = [no_load_speed(figures[c]) for c in ("value", "nls", "pattern-search")]
    value, ps = figures["value"], figures["pattern-search"]
    moved = max(abs(off(ps[name], value[name])) for name in ("B", "J"))
    return (
        "The three columns cannot fit one record: they turn at "
        f"{speeds[0]:.1f}, {speeds[1]:.1f} and {speeds[2]:.1f} rad/s per volt.",
        f"The NLS inertia is {off(figures['nls']['J'], value['J']):+.0f} % from the value column, "
        "which is a first guess made by hand and no truth.",
        f"Pattern search left B and J within {moved:.2f} % of that guess: it never moved them.",
        f"L/R = {1e3 * value['L'] / value['R']:.0f} ms is no small motor's.",
    )


def _table_3() -> tuple[str, ...]:
    figures = printed()["table3"]
    value, first, second = (figures[c] for c in ("value", "acceleration", "least-squares"))
    currents = [c["T0"] / c["K"] for c in (first, second)]
    sheet = value["T0"] / value["Kt"]
    return (
        f"J of the acceleration method is {first['J'] / value['J']:.0f} times the value column, "
        f"and T0 {first['T0'] / value['T0']:.0f} times: another load, or other units.",
        f"T0/K is {currents[0]:.4f} and {currents[1]:.4f} A in the two columns and B/K agrees as "
        "well, so both use the same steady state and differ in K and J only.",
        f"That current at no load is {currents[0]:.1f} A where the value column gives "
        f"{sheet:.2f} A.",
        f"L/R of the least squares is {1e3 * second['L'] / second['R']:.4f} ms: L was set, "
        "not identified.",
    )


def _table_4() -> tuple[str, ...]:
    figures = printed()["table4"]
    value, best, bees = (figures[c] for c in ("value", "de-best-1-bin", "abc"))
    loads = ", ".join(f"{off(bees[name], value[name]):+.0f}" for name in ("Ta", "Tb", "Tc"))
    return (
        f"DE/best/1/bin is called acceptable with Ta {off(best['Ta'], value['Ta']):+.0f} %, "
        f"and ABC with Ta, Tb, Tc {loads} %.",
        "One step of voltage hardly shows the load torques, whatever searches: the staircase does.",
        "Section 2.3.1 says that TLBO takes twice the time, section 3.2 that DE does. TLBO spends "
        "two evaluations on an individual a generation; here all have equal evaluations.",
    )


def _table_5() -> tuple[str, ...]:
    figures = printed()["table5"]
    value, std, aiwf = figures["value"], figures["pso"], figures["pso-aiwf"]
    said = figures["pso-percent"]["b"]
    said_aiwf = figures["pso-aiwf-percent"]
    true_b = table(5)[0].truth["b"]
    return (
        f"b = {value['b']} is a slip: the printed {said:.0f} % of STD needs b = {true_b} "
        f"({off(std['b'], true_b):.0f} %; {value['b']} gives {off(std['b'], value['b']):.1f} %).",
        f"AIWF's J1 and J2 are printed {said_aiwf['J1']} and {said_aiwf['J2']} % off, but the "
        f"printed values are {abs(off(aiwf['J1'], value['J1'])):.1f} and "
        f"{abs(off(aiwf['J2'], value['J2'])):.1f} % off.",
        "CIW is not best on all: by the table's own errors CI has the better J1 and J2.",
        "The opposite errors of J1 and J2 (their sum is right to 2 %) are what a step of torque "
        "gives: it does not excite the resonance. With a random binary torque CIW and CI are "
        "right below 1 %.",
        "Equation 20 has both signs wrong and (21) lacks an integral: here the spring's torque is "
        "Ks times the angle between the masses.",
    )


def _table_6() -> tuple[str, ...]:
    figures = printed()["table6"]
    truth = figures["value"]
    twin = speed_twin(truth, 0.55, 0.0105)
    words = ", ".join(f"{name} {twin[name]:.5g}" for name in ("R", "L", "K", "J", "B"))
    apart = speed_mse(twin, truth)
    return (
        f"The motor {words} turns exactly as the nominal one (mean square difference "
        f"{apart:.0e}). Speed alone cannot identify five parameters, and an MSE of 1e-16 proves "
        "nothing about them.",
        f"CIPSO's printed parameters give a speed MSE of {speed_mse(figures['pso-ci'], truth):.2e} "
        f"at 1 V, not {figures['mse']['pso-ci']:.3g}.",
        f"SPSO's give {speed_mse(figures['pso-ldw'], truth):.2e}, not "
        f"{figures['mse']['pso-ldw']:.3g}: its steady speed is "
        f"{off(no_load_speed(figures['pso-ldw']), no_load_speed(truth)):+.0f} % off.",
    )


def _table_7() -> tuple[str, ...]:
    figures = printed()["table7"]
    value, sm, cuckoo = (figures[c] for c in ("value", "steiglitz-mcbride", "cuckoo-m"))
    said, said_cuckoo = figures["steiglitz-mcbride-percent"], figures["cuckoo-m-percent"]
    of_estimate = [100.0 * abs(sm[n] - value[n]) / sm[n] for n in ("R", "K")]
    return (
        f"Steiglitz-McBride's B is {off(sm['B'], value['B']):.2f} % off, not {said['B']}.",
        f"The modified cuckoo's B is {off(cuckoo['B'], value['B']):.2f} % off, not "
        f"{said_cuckoo['B']}: by (27) it must equal K's {said_cuckoo['K']}.",
        f"R and K of Steiglitz-McBride are relative to the estimate ({of_estimate[0]:.2f}, "
        f"{of_estimate[1]:.2f}), the other errors to the nominal value.",
        "Without noise Steiglitz-McBride is exact, so the printed errors come from a measured or "
        "noisy record, which the table does not describe.",
        "The standard cuckoo that the caption announces is missing.",
    )


def _tests(number: int) -> tuple[str, ...]:
    figures = printed()[f"table{number}"]
    truth = table(number)[0].truth
    a = truth["K"] ** 2 / (truth["R"] * truth["B"])
    k_percent = figures["GWO_m"][1][PERCENT_ORDER.index("K")]
    r_percent = figures["GWO_m"][1][PERCENT_ORDER.index("R")]
    tied = min(
        (tied_r(k_percent, a, sign) for sign in (1.0, -1.0)), key=lambda r: abs(r - r_percent)
    )
    j_percent = ", ".join(str(row[PERCENT_ORDER.index("J")]) for row in figures["Jaya_m"])
    floor = abs(printed_rule_bias(number))
    return (
        "The errors are relative to the estimate, not to the nominal value as the text says. "
        f"With K {k_percent} % off, (26) and (27) force R {tied:.3f} % off (GWO_m test 2 prints "
        f"{r_percent}).",
        f"No search can do better in J than {floor:.3f} % with the printed rule of (29), the "
        f"largest dω/dt: Jaya_m prints {j_percent}. With dω/dt at the largest current it is gone.",
        "CSO_o is not the plain search that its label says: its B% equals its K% in every row, "
        "which (27) alone does. CSO_m does not follow (29) either. Here they are K, L, J free, "
        "and K, L free with J within a tenth of the rule's.",
        "The plain sum of (31) adds amperes to rad/s. At one to one the searches over five "
        "parameters do not converge at all. At about 100 rad/s to the ampere the table appears, "
        "and there a large budget lets the original Jaya pass below the modified one's floor.",
        "The stop at a cost below .1 has no unit: it depends on sample time, length and weights.",
    )


_SENTENCES: dict[int, Callable[[], tuple[str, ...]]] = {
    2: _table_2,
    3: _table_3,
    4: _table_4,
    5: _table_5,
    6: _table_6,
    7: _table_7,
    8: lambda: _tests(8),
    9: lambda: _tests(9),
}
