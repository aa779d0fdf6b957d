"""Least squares and likelihood for any model: no motor, no capture."""
