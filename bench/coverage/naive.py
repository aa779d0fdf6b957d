"""The fit that ignores the chain: what the figures would say without any of it declared.

Samples are taken as instants at their ticks; there is no bridge, no lead, no dead time and no PWM;
no delay; the clock and every gain are exact, so the interval has no instrument part.
"""

from __future__ import annotations

from dataclasses import replace

from motorid.capture.model import SUPPLY, VOLTAGE, Capture, Channel, Wiring


def forget_chain(capture: Capture) -> Capture:
    """The same readings, with nothing said of how they were taken."""
    channels = {name: _bare(channel) for name, channel in capture.channels.items()}
    wiring = Wiring(
        counts_per_turn=capture.wiring.counts_per_turn,
        supply_voltage_v=capture.wiring.supply_voltage_v,
    )
    return replace(capture, channels=channels, wiring=wiring, clock_uncertainty=0.0)


def _bare(channel: Channel) -> Channel:
    return replace(
        channel,
        kind="instant",
        aperture_s=0.0,
        delay_s=0.0,
        pwm_phase=None,
        gain_uncertainty=0.0,
        delay_uncertainty_s=0.0,
        sense={VOLTAGE: "terminals", SUPPLY: "supply"}.get(channel.name),
    )
