"""Logs with volts, or a command, and a motion, but no current: time constant, gain, friction."""
