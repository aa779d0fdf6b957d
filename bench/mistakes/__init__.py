"""Ordinary mistakes of a bench, done on purpose, and what motorid says of each."""
