"""One fault of the measuring chain a module."""
