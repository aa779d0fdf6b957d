"""motorid flash, and the files that it flashes."""
