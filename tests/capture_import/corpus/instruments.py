"""Text tables in the layouts of oscilloscopes, analysers and LabVIEW, by probes of both kinds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.capture_import.corpus.bench_log import LENGTH_S, PERIOD_S, columns, lines, log, text

ROWS = len(log()["time"])
COUNTS = 100.0  # a turn
VA = {"voltage": 1.0, "current": 1.0}
TVA = {"time": 1.0, **VA}


def rigol_old(path: Path) -> None:
    head = f"X,CH1,CH2,Start,Increment,\nSequence,Volt,Ampere,0.000000e+00,{PERIOD_S:e}\n"
    rows = [f"{k},{u:.4e},{i:.4e},," for k, (u, i) in enumerate(columns(**VA))]
    path.write_text(head + lines(rows), encoding="ascii")


def rigol_new(path: Path) -> None:
    head = f"CH1(V),CH2(A),t0 =0.000000e+00s, tInc = {PERIOD_S:e}s,\n"
    rows = [f"{u:.4e},{i:.4e},," for u, i in columns(**VA)]
    path.write_text(head + lines(rows), encoding="ascii")


def tektronix(path: Path) -> None:
    head = [
        "Model,MDO3024", "Firmware Version,1.26", "", "Waveform Type,ANALOG,", "Point Format,Y,",
        "Horizontal Units,s,", "Horizontal Scale,0.2,", f"Sample Interval,{PERIOD_S:g},",
        f"Record Length,{ROWS},", "Gating,0.0% to 100.0%,", "Probe Attenuation,10,1",
        "Vertical Units,V,A", "Vertical Offset,0,0", "Vertical Scale,5,2", "Vertical Position,0,0",
        ",", "Label,,", "TIME,CH1,CH2",
    ]  # fmt: skip
    path.write_text(text(lines(head), columns(**TVA)), encoding="ascii")


def keysight(path: Path) -> None:
    rows = [f"{t:+.6E},{u:+.5E},{i:+.5E}" for t, u, i in columns(**TVA)]
    path.write_text(lines(["x-axis,1,2", "second,Volt,Ampere", *rows]), encoding="ascii")


def siglent(path: Path) -> None:
    head = [
        f"Record Length,Analog:{ROWS}", f"Sample Interval,Analog:{PERIOD_S:.6E}",
        "Vertical Units,CH1:V,CH2:A", "Vertical Scale,CH1:5.00,CH2:2.00",
        "Vertical Offset,CH1:0.00000,CH2:0.00000", "Horizontal Units,s",
        "Horizontal Scale,2.00000E-01", "Model Number,SDS1104X-E", "Source,CH1,CH2",
        "Second,Volt,Ampere",
    ]  # fmt: skip
    rows = [f"{t:.11f},{u:.5f},{i:.5f}" for t, u, i in columns(**TVA)]
    path.write_text(lines([*head, *rows]), encoding="ascii")


def picoscope(path: Path) -> None:
    head = "Time,Channel A,Channel B\n(ms),(V),(A)\n\n"
    path.write_text(text(head, columns(time=1e3, voltage=1.0, current=1.0)), encoding="ascii")


def saleae(path: Path) -> None:
    head = "Time [s],Motor voltage,Motor current,Tacho rpm\n"
    path.write_text(text(head, columns(**TVA, speed=60 / 6.283185307179586)), encoding="ascii")


def hantek(path: Path) -> None:
    rows = [f"{k},{t:.6g},{u:.4f},{i:.4f}" for k, (t, u, i) in enumerate(columns(**TVA))]
    path.write_text(lines(["nr,time,ch1,ch2", *rows]), encoding="ascii")


def labview(path: Path) -> None:
    each = "\t".join
    head = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
        "Decimal_Separator\t.", "Multi_Headings\tNo", "X_Columns\tOne", "Time_Pref\tRelative",
        "Operator\tLab", "Date\t2026/11/02", "Time\t10:41:12.1234567", "***End_of_Header***\t",
        "\t", "Channels\t2\t\t\t", each(["Samples", *[f"{ROWS}"] * 2, "\t"]),
        each(["Date", *["2026/11/02"] * 2, "\t"]), each(["Time", *["10:41:12.12"] * 2, "\t"]),
        each(["Y_Unit_Label", "Volts", "Amps", "\t"]), each(["X_Dimension", *["Time"] * 2, "\t"]),
        each(["X0", *["0.0000000000000000E+0"] * 2, "\t"]),
        each(["Delta_X", *[f"{PERIOD_S:f}"] * 2, "\t"]),
        "***End_of_Header***\t\t\t", each(["X_Value", "Voltage_0", "Current_0", "Comment"]),
    ]  # fmt: skip
    rows = [f"{t:.6f}\t{u:.6f}\t{i:.6f}" for t, u, i in columns(**TVA)]
    path.write_text(lines([*head, *rows]), encoding="ascii")


def excel_rounded_stamps(path: Path) -> None:
    """A monitor's stamps beside a counter: the counter is no time."""
    head = "Sample;Zeit (ms);Ankerspannung (V);Ankerstrom (A)\n"
    rows = [
        f"{k};{1e3 * t:.0f};{u:.3f};{i:.4f}".replace(".", ",")
        for k, (t, u, i) in enumerate(columns(**TVA))
    ]
    path.write_text(head + lines(rows), encoding="latin-1")


def logic_analyser(path: Path) -> None:
    """Saleae's digital export: a row for each change of one line; 100 counts a turn."""
    turns = log()["position"] / (2.0 * np.pi)
    time = np.linspace(0.0, LENGTH_S, 60_001)
    count = np.floor(np.interp(time, log()["time"], turns) * COUNTS).astype(int)
    a, b = (count % 4 // 2 + count % 2) % 2, count % 4 // 2
    rows = np.flatnonzero(np.r_[True, np.diff(count) != 0])
    cells = (f"{time[row]:.9f},{a[row]},{b[row]}" for row in rows)
    path.write_text(lines(["Time [s],Encoder A,Encoder B", *cells]), encoding="ascii")
