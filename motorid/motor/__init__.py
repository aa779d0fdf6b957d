"""Parameters of the motor, and the response model that a fit evaluates."""
