"""What drives the motor between the bridge and its terminals, by its PWM, supply and diodes."""
