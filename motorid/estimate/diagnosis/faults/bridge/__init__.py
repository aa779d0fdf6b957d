"""Faults of what drives the motor, where its voltage is commanded from a supply that is read."""
