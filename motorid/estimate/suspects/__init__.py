"""Suspects: what in the measuring chain may have spoiled a fit, and how the data show it."""
