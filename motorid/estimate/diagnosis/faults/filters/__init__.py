"""A channel behind a filter that nobody declared: a low-pass, or a high-pass."""
