"""A current's sensor that reads something else than the motor's current with its sign."""
