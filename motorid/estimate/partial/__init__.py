"""Fits of captures that lack a voltage, a current, a motion or all motion."""
