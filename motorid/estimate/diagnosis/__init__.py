"""What the data contradict: remarks, faults of the measuring chain, what cannot be identified."""
