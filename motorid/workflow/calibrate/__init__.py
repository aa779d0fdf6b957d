"""The walk through a calibration, for a person or a script, and the file that it leaves."""
