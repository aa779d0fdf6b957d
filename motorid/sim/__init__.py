"""The simulated rig behind sim://: plant, sensors, board, faults."""
