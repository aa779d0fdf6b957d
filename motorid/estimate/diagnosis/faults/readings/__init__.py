"""Readings that repeat, or that stand alone."""
