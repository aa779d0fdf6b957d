"""The search for a better model than the six parameters."""
