"""Text, JSON and HTML of an estimate. No computation."""
