"""A board's evidence on real hardware: the suite, a guided run, and one bundle that can be sent."""
