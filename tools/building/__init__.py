"""How motorid is built: for this machine without a compiler, and into wheels for others."""
