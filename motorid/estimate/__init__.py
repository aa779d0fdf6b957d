"""Closed forms, output-error fit, uncertainty, identifiability."""
