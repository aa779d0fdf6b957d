"""What a channel shows of the motor: offsets, gains, filters."""
