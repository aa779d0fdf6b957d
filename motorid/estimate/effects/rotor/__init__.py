"""What repeats with the rotor's angle, in the motor and in its encoder."""
