"""Tables and logs as students, boards and spreadsheets in several countries write them."""

from __future__ import annotations

import json
from datetime import datetime, timedelta
from pathlib import Path

from tests.capture_import.corpus.bench_log import PERIOD_S, RPM, columns, lines, text

ALL = {"time": 1.0, "voltage": 1.0, "current": 1.0, "speed": RPM}


def german(path: Path) -> None:
    head = "Zeit [s];Spannung [V];Strom [A];Drehzahl [1/min]\n"
    path.write_text(text(head, columns(**ALL), separator=";", decimal=","), encoding="latin-1")


def french(path: Path) -> None:
    head = "Temps (s);Tension (V);Intensité (mA);Vitesse (tr/min)\n"
    table = columns(time=1.0, voltage=1.0, current=1e3, speed=RPM)
    path.write_text(text(head, table, separator=";", decimal=","), encoding="latin-1")


def spanish(path: Path) -> None:
    head = "Tiempo_s,Voltaje_V,Corriente_A,Velocidad_rpm\n"
    path.write_text(text(head, columns(**ALL)), encoding="utf-8")


def portuguese(path: Path) -> None:
    head = "Tempo\tTensão\tCorrente\tVelocidade\ns\tV\tA\trad/s\n"
    table = columns(time=1.0, voltage=1.0, current=1.0, speed=1.0)
    path.write_text(text(head, table, separator="\t"), encoding="utf-8")


def chinese(path: Path) -> None:
    path.write_text(
        text("时间(s),电压(V),电流(A),转速(rpm)\n", columns(**ALL)), encoding="utf-8-sig"
    )


def russian(path: Path) -> None:
    head = "Время (с);Напряжение (В);Ток (А);Скорость (об/мин)\n"
    path.write_text(text(head, columns(**ALL), separator=";", decimal=","), encoding="utf-8-sig")


def no_units(path: Path) -> None:
    path.write_text(text("t,u,i,n\n", columns(**ALL)), encoding="ascii")


def millis(path: Path) -> None:
    rows = [f"{round(t * 1e3)},{u:.2f},{i * 1e3:.0f},{n:.1f}" for t, u, i, n in columns(**ALL)]
    path.write_text(lines(["millis,motor_V,current_mA,rpm", *rows]), encoding="ascii")


def reversed_current(path: Path) -> None:
    table = columns(time=1.0, voltage=1.0, current=-1.0, speed=1.0)
    path.write_text(text("time_s,voltage,current,omega\n", table), encoding="ascii")


def angle_and_speed(path: Path) -> None:
    table = columns(time=1.0, voltage=1.0, current=1.0, speed=RPM, position=360 / 6.283185307179586)
    path.write_text(text("time (s),voltage,current,speed,angle (deg)\n", table), encoding="ascii")


def only_speed(path: Path) -> None:
    rows = [f"{t * 1e3:.0f},{n:.1f},{u / 12 * 255:.0f}" for t, u, _, n in columns(**ALL)]
    path.write_text(
        lines(["Timestamp(ms),Motor_Speed(RPM),Commanded_PWM", *rows]), encoding="ascii"
    )


def plotter(path: Path) -> None:
    start = datetime(2026, 11, 2, 23, 59, 59, 400000)
    rows = []
    for t, u, i, n in columns(**ALL):
        at = (start + timedelta(seconds=float(t))).strftime("%H:%M:%S.%f")[:-3]
        rows.append(f"{at} -> voltage:{u:.2f},current_mA:{1e3 * i:.0f},rpm:{n:.1f}")
    path.write_text(lines(rows), encoding="ascii")


def iso_times(path: Path) -> None:
    start = datetime(2026, 11, 2, 10, 41, 12)
    rows = []
    for t, u, i, n in columns(**ALL):
        at = (start + timedelta(seconds=float(t))).isoformat(timespec="milliseconds")
        rows.append(f"{at}Z,{u:.3f},{i:.4f},{n:.1f}")
    path.write_text(
        lines(["timestamp,motor voltage (V),motor current (A),rpm", *rows]), encoding="ascii"
    )


def nested_json(path: Path) -> None:
    rows = [
        json.dumps({"t_us": round(t * 1e6), "motor": {"voltage_V": u, "current_A": i, "rpm": n}})
        for t, u, i, n in columns(**ALL)
    ]
    path.write_text(lines(rows), encoding="utf-8")


def row_numbers(path: Path) -> None:
    """A sample number, and the rate in a comment: nobody says how long a sample takes."""
    rows = [f"{k},{u:.3f},{i:.4f},{n:.1f}" for k, (_, u, i, n) in enumerate(columns(**ALL))]
    path.write_text(lines(["sample,voltage (V),current (A),rpm", *rows]), encoding="ascii")


def rate_in_header(path: Path) -> None:
    rows = [f"{u:.3f},{i:.4f},{n:.1f}" for _, u, i, n in columns(**ALL)]
    head = [f"Sample Rate,{1 / PERIOD_S:g}", "Voltage (V),Current (A),Speed (rpm)"]
    path.write_text(lines([*head, *rows]), encoding="ascii")


def swapped_names(path: Path) -> None:
    """Volts under the name of the current, and amperes under that of the voltage."""
    table = columns(time=1.0, current=1.0, voltage=1.0, speed=RPM)
    path.write_text(text("time_s,voltage_V,current_A,speed_rpm\n", table), encoding="ascii")
