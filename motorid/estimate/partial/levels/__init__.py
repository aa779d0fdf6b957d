"""Drives at one level, and at steady levels: what each of them shows of a motor."""
