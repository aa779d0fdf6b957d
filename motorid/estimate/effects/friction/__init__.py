"""What brakes the rotor beyond B and T0."""
