"""A zero of a channel that is not where it is declared."""
