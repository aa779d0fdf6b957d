"""Captures under load: long, fast, on a slow disk or a slow terminal."""
