"""What the motor's iron does when current flows."""
