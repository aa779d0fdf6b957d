"""Estimation: captures of one motor in, values with honest uncertainty out; room by room."""
