"""One suite for every board: whatever speaks the protocol must pass it."""
