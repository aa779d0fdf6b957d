"""The emulated RP2040's converter is as good as its data sheet says, and its descriptors say so."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.wire.enums import Channel
from tests.conformance.boards import FIRMWARE, ROOT, module_of, opened, pico_lacks
from tests.conformance.client import Client

Floats = NDArray[np.float64]
CODES, REFERENCE_V = 4096, 3.0
CONVERSION = 250  # cycles of 8 ns
HERTZ = 997.0
EFFECTIVE_BITS = (8.5, 9.0)  # data sheet of the RP2040, 4.9.3: 8.7
MOTOR = "dunkermotoren-gr42"
CONVERTER = """
#include "rig.c"
static struct rig bench;
void begin(int from, const double *wide, double noise, double wanders, double lasts) {
    memset(&bench, 0, sizeof bench);
    seed(&bench, (uint64_t)from);
    struct rig_params *const p = &bench.par;
    p->clock_hz = 125e6; p->reference = 3.0; p->codes = 4096.0; p->shunt = 1.0; p->zero = 1.5;
    p->noise = noise; p->reference_noise = wanders; p->reference_noise_s = lasts;
    p->gain[CURRENT] = 1.0;
    memcpy(p->wide, wide, sizeof p->wide);
    bench.at = UINT64_MAX; /* nothing moves but what is given */
}
int convert(uint64_t cycle, double signal_v) {
    bench.filtered[CURRENT] = signal_v;
    return rig_convert(&bench, cycle, CURRENT);
}
"""


@pytest.fixture(scope="module")
def converter(tmp_path_factory: pytest.TempPathFactory) -> Any:
    if not shutil.which("gcc"):
        pytest.skip("no C compiler gcc: the converter is not built")
    folder = tmp_path_factory.mktemp("converter")
    (folder / "bench.c").write_text(CONVERTER)
    rooms = [FIRMWARE / "emulator", ROOT / "motorid" / "sim"]
    plant = ("plant", "equations", "iron", "bridge", "lowpass")
    words = ["gcc", "-O2", "-shared", "-fPIC", *(f"-I{room}" for room in rooms)]
    sources = [folder / "bench.c", *(rooms[1] / f"{name}.c" for name in plant)]
    subprocess.run([*words, "-o", folder / "bench.so", *sources, "-lm"], check=True)
    code: Any = ctypes.CDLL(str(folder / "bench.so"))
    code.convert.argtypes = [ctypes.c_uint64, ctypes.c_double]
    double = ctypes.c_double
    code.begin.argtypes = [ctypes.c_int, ctypes.POINTER(double), double, double, double]
    return code


def parts() -> Any:
    """The emulator's figures of a Pico's converter."""
    return module_of(FIRMWARE / "emulator" / "emu.py").RP2040


def begin(converter: Any, seed: int) -> None:
    chip = parts()
    wide = np.random.default_rng(seed).uniform(*chip.wide, 4)
    figures = chip.noise_lsb, chip.reference_noise, chip.reference_noise_s
    converter.begin(seed, (ctypes.c_double * 4)(*wide), *figures)


def codes_of(converter: Any, signal_v: Floats) -> Floats:
    return np.array([converter.convert(CONVERSION * n, v) for n, v in enumerate(signal_v)], float)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 5))
def test_a_full_sine_has_as_many_effective_bits_as_the_data_sheet_says(
    converter: Any, seed: int
) -> None:
    begin(converter, seed)
    angle = 2 * np.pi * HERTZ * CONVERSION * 8e-9 * np.arange(30_000)
    shown = codes_of(converter, 0.49 * REFERENCE_V * np.sin(angle))
    basis = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
    left = shown - basis @ np.linalg.lstsq(basis, shown, rcond=None)[0]
    bits = np.log2(CODES / (np.sqrt(12.0) * left.std()))
    assert EFFECTIVE_BITS[0] < bits < EFFECTIVE_BITS[1]


@pytest.mark.slow
def test_the_reference_s_noise_is_a_share_of_the_signal_and_lasts(converter: Any) -> None:
    """Without a signal there is none of it: zeros are divided from the reference."""
    chip, scatter = parts(), {}
    for share in (0.0, 0.8):
        converter.begin(3, (ctypes.c_double * 4)(), 0.0, 100 * chip.reference_noise, 0.44e-3)
        shown = codes_of(converter, np.full(20_000, share * REFERENCE_V / 2))
        scatter[share] = shown.std()
        lag = round(0.44e-3 / (CONVERSION * 8e-9))
        centred = shown - shown.mean()
        if share:
            kept = float(centred[lag:] @ centred[:-lag] / (centred @ centred))
            assert kept == pytest.approx(np.exp(-1.0), abs=0.15)
    assert scatter[0.0] == 0.0
    expected = 100 * chip.reference_noise * 0.8 * CODES / 2
    assert scatter[0.8] == pytest.approx(expected, rel=0.15)


@pytest.mark.slow
def test_a_descriptor_declares_as_much_noise_as_the_readings_have() -> None:
    """At rest the converter's, and at a large signal its reference's, too."""
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")
    with opened("pico", motor=MOTOR) as board:
        client = Client(board.port)
        client.bring_up()
        board.port.board.set("locked", 1.0)  # type: ignore[attr-defined]
        record = client.run(client.coast(600), client.drive(1200, 1.0), client.coast(8))
        for channel in (Channel.CURRENT, Channel.TERMINAL_VOLTAGE):
            noise, raw = client.descriptors[channel]["noise"], record.channel(channel)
            resting, driven = raw[50:550].astype(float), raw[1200:1790].astype(float)
            trend = np.polynomial.Polynomial.fit(np.arange(len(driven)), driven, 3)
            left = driven - trend(np.arange(len(driven)))
            assert 0.3 * noise < resting.std() < noise
            assert resting.std() < left.std() < 1.3 * noise, channel
        assert client.descriptors[Channel.CURRENT]["step_uncertainty"] > 0.0
