"""What separates R and K as run from R and K at 25 °C."""
