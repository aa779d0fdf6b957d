"""Influence quantities: what is no parameter, but moves a reading."""
