"""Every influence quantity: the order is that of the unknowns of a capture."""

from __future__ import annotations

from collections.abc import Iterator

from motorid.estimate.effects.bridge.pulse_distortion import PULSE_DISTORTION
from motorid.estimate.effects.bridge.supply_path import SUPPLY_PATH
from motorid.estimate.effects.bridge.terminal_load import TERMINAL_LOAD
from motorid.estimate.effects.friction.friction_by_direction import FRICTION_BY_DIRECTION
from motorid.estimate.effects.friction.friction_drift import FRICTION_DRIFT
from motorid.estimate.effects.friction.load_friction import LOAD_FRICTION
from motorid.estimate.effects.friction.quadratic_friction import QUADRATIC_FRICTION
from motorid.estimate.effects.friction.windage import WINDAGE
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Use
from motorid.estimate.effects.iron.armature_reaction import ARMATURE_REACTION
from motorid.estimate.effects.iron.eddies_in_pulses import EDDIES_IN_PULSES
from motorid.estimate.effects.iron.eddy_currents import EDDY_CURRENTS
from motorid.estimate.effects.iron.saturation import SATURATION
from motorid.estimate.effects.reading.converter_steps import CONVERTER_STEPS
from motorid.estimate.effects.reading.current_common_mode import CURRENT_COMMON_MODE
from motorid.estimate.effects.reading.current_coupling import CURRENT_COUPLING
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.current_gain import CURRENT_GAIN
from motorid.estimate.effects.reading.current_nonlinearity import CURRENT_NONLINEARITY
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.reading.driven_current_offset import DRIVEN_CURRENT_OFFSET
from motorid.estimate.effects.reading.missed_counts import MISSED_COUNTS
from motorid.estimate.effects.reading.motion_gain import MOTION_GAIN
from motorid.estimate.effects.reading.position_origin import POSITION_ORIGIN
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.reading.speed_dead_band import SPEED_DEAD_BAND
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.effects.reference.temperature import (
    AMBIENT_TEMPERATURE,
    COPPER_COEFFICIENT,
    MAGNET_COEFFICIENT,
    SELF_HEATING,
)
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_eccentricity import ENCODER_ECCENTRICITY
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.friction_ripple import FRICTION_RIPPLE
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.source.bridge_drop import BRIDGE_DROP
from motorid.estimate.effects.source.brush_bend import BRUSH_BEND
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.commutation_resistance import COMMUTATION_RESISTANCE
from motorid.estimate.effects.source.dead_time_diodes import DEAD_TIME_DIODES
from motorid.estimate.effects.source.dead_time_turn import DEAD_TIME_TURN
from motorid.estimate.effects.source.diode_drops import DIODE_DROPS
from motorid.estimate.effects.source.duty_of_volts import DUTY_OF_VOLTS
from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.effects.source.reference_drift import REFERENCE_DRIFT
from motorid.estimate.effects.source.reference_sag import REFERENCE_SAG
from motorid.estimate.effects.source.sampling_phases import SAMPLING_PHASES
from motorid.estimate.effects.source.source_level import SOURCE_LEVEL
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.effects.source.voltage_noise import VOLTAGE_NOISE
from motorid.estimate.effects.source.voltage_offset import VOLTAGE_OFFSET
from motorid.estimate.effects.source.winding_warming import WINDING_WARMING
from motorid.estimate.effects.source.wiring_resistance import WIRING_RESISTANCE
from motorid.estimate.effects.state.coast_start import COAST_START
from motorid.estimate.effects.state.cogging_phase import COGGING_PHASE
from motorid.estimate.effects.state.initial_current import INITIAL_CURRENT
from motorid.estimate.effects.state.initial_speed import INITIAL_SPEED
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.effects.state.ripple_phase import RIPPLE_PHASE
from motorid.estimate.effects.timing.clock import CLOCK
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.effects.timing.voltage_delay import VOLTAGE_DELAY
from motorid.estimate.effects.timing.voltage_jump import VOLTAGE_JUMP
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_second_order import CURRENT_SECOND_ORDER
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_second_order import SPEED_SECOND_ORDER
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_second_order import VOLTAGE_SECOND_ORDER
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING

UNSTATED = (CURRENT_LAG, CURRENT_SMOOTHING, SPEED_SMOOTHING, VOLTAGE_SMOOTHING)
"""Of a log's channels, where nobody says anything of them."""
SECOND_ORDER = {
    CURRENT_SMOOTHING: CURRENT_SECOND_ORDER,
    SPEED_SMOOTHING: SPEED_SECOND_ORDER,
    VOLTAGE_SMOOTHING: VOLTAGE_SECOND_ORDER,
}
"""Of a low-pass that was found, its second order."""
WITHOUT_WORD = (VOLTAGE_LATE, *UNSTATED, *SECOND_ORDER.values())
CAPTURED = (
    # unknowns of every fit, as far as they apply
    CURRENT_OFFSET,
    POSITION_ORIGIN,
    VOLTAGE_OFFSET,
    VOLTAGE_JUMP,
    VOLTAGE_LATE,
    BRUSH_DROP,
    BRUSH_BEND,
    BRIDGE_DROP,
    WINDING_WARMING,
    DEAD_TIME_DIODES,
    DEAD_TIME_TURN,
    PULSE_DISTORTION,
    INITIAL_SPEED,
    INITIAL_CURRENT,
    SOURCE_LEVEL,
    COAST_START,
    ENCODER_ECCENTRICITY,
    # lines of the budget, as far as they are declared
    CURRENT_GAIN,
    CURRENT_NONLINEARITY,
    CONVERTER_STEPS,
    CURRENT_FILTER,
    VOLTAGE_GAIN,
    MOTION_GAIN,
    REFERENCE_DRIFT,
    CLOCK,
    CURRENT_DELAY,
    VOLTAGE_DELAY,
    MOTION_DELAY,
    SAMPLING_PHASES,
    DUTY_OF_VOLTS,
    DIODE_DROPS,
    WIRING_RESISTANCE,
    TERMINAL_LOAD,
    EDDIES_IN_PULSES,
    # lines of the budget by what is usual, as far as the readings leave them open
    LOAD_FRICTION,
    WINDAGE,
    FRICTION_DRIFT,
    ARMATURE_REACTION,
    COMMUTATION_RESISTANCE,
    SATURATION,
    EDDY_CURRENTS,
)
"""What a capture of a driven motor has by itself."""
ADDED = (
    # looked for where residuals ask for them
    *UNSTATED,
    *SECOND_ORDER.values(),
    K_RIPPLE,
    R_RIPPLE,
    COGGING,
    FRICTION_RIPPLE,
    ENCODER_ERROR,
    SPEED_FILTER,
    SPEED_DEAD_BAND,
    MISSED_COUNTS,
    *(kind for kinds in SMOOTHED.values() for kind in kinds.values()),
    DRIVEN_CURRENT_OFFSET,
    CURRENT_COUPLING,
    CURRENT_COMMON_MODE,
    REFERENCE_SAG,
    SUPPLY_PATH,
    QUADRATIC_FRICTION,
    FRICTION_BY_DIRECTION,
    # of wider models
    INITIAL_WARMTH,
    COGGING_PHASE,
    RIPPLE_PHASE,
    # lines whose size other rooms know
    VOLTAGE_NOISE,
    HELD_INDUCTANCE,
    AMBIENT_TEMPERATURE,
    SELF_HEATING,
    COPPER_COEFFICIENT,
    MAGNET_COEFFICIENT,
)
REGISTRY = (*CAPTURED, *ADDED)
BY_NAME = {quantity.name: quantity for quantity in REGISTRY}


def used(use: Use) -> Iterator[InfluenceQuantity]:
    """Those of every capture that a fit estimates, or propagates."""
    return (quantity for quantity in CAPTURED if quantity.use is use)
