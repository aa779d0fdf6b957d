"""What is stated of the PWM, held against the readings."""
