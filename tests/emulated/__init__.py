"""The boards' firmware in the emulator: timing, safety by the pins, and identification."""
