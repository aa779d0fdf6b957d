"""Looks at somebody else's table and proposes what its columns are, before anything is imported."""
