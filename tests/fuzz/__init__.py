"""Fuzzing; each harness runs by itself and is replayed on its corpus by the suite."""
