"""Captures under faults, drawn by seed or listed, and what must hold of each."""
