"""Drives at one level, and at steady levels."""
