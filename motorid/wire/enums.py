"""The protocol's enumerations. Generated from spec.toml: do not edit."""

from enum import IntEnum


class Status(IntEnum):
    OK = 0
    UNKNOWN_COMMAND = 1
    BAD_LENGTH = 2
    BAD_VALUE = 3
    BAD_STATE = 4
    HASH_MISMATCH = 5
    NOT_CONFIGURED = 6
    FAULT_LATCHED = 7
    PROGRAM_FULL = 8
    PROGRAM_EMPTY = 9
    NOT_SUPPORTED = 10
    EDGE_CEILING = 11
    MAJOR_MISMATCH = 12
    NOT_AT_REST = 13
    INPUT_OPEN = 14
    NO_FRONT_END = 15


class State(IntEnum):
    BOOT = 0
    IDLE = 1
    CONFIGURED = 2
    LOADED = 3
    RUNNING = 4
    ZEROING = 5
    FAULTED = 6


class StepKind(IntEnum):
    COAST = 0
    DRIVE_DUTY = 1
    DRIVE_VOLTS = 2
    BRAKE = 3


class Decay(IntEnum):
    NONE = 0
    SYNCHRONOUS_SLOW = 1
    DIODE = 2
    FAST = 3


class Channel(IntEnum):
    CURRENT = 0
    TERMINAL_VOLTAGE = 1
    SUPPLY_VOLTAGE = 2
    POSITION = 3


class ChannelKind(IntEnum):
    INSTANT = 0
    MEAN = 1


class Unit(IntEnum):
    COUNT = 0
    AMPERE = 1
    VOLT = 2


class Mode(IntEnum):
    STREAM = 0
    BURST = 1


class Fault(IntEnum):
    NONE = 0
    OVER_CURRENT = 1
    OVER_SPEED = 2
    SUPPLY_LOW = 3
    SUPPLY_HIGH = 4
    RUN_TIME = 5
    HOST_SILENCE = 6
    ENCODER_EDGES = 7
    DRIVER = 8
    WATCHDOG = 9
    OVER_VOLTAGE = 10
    WRONG_SIGN = 11
    INPUT_OPENED = 12


class EndReason(IntEnum):
    COMPLETED = 0
    STOPPED = 1
    FAULT = 2


class ResetCause(IntEnum):
    POWER_ON = 0
    EXTERNAL = 1
    BROWN_OUT = 2
    WATCHDOG = 3
    SOFTWARE = 4
    UNKNOWN = 5


class Feature(IntEnum):
    VOLTAGE_LIMIT = 0
    INPUTS = 1
    SIGN_CHECK = 2
    FRONT_END = 3


class Input(IntEnum):
    PART_PRESENT = 0
    GUARD_CLOSED = 1


class Sensor(IntEnum):
    SHUNT = 0
    HALL = 1
    MAGNITUDE = 2


class Bridge(IntEnum):
    MOSFET = 0
    BIPOLAR = 1
    IN_IN = 2
    PWM_DIR = 3
    PWM_DIR_BARE = 4


class FrontEndSource(IntEnum):
    NONE = 0
    COMPILED = 1
    STORED = 2
