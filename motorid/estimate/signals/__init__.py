"""What a capture recorded, on the grid of the fit; and what drives the motor."""
