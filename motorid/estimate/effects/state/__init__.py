"""In which state a run, or a coast, begins."""
