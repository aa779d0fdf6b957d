"""What a log shows that may be its motor as well as its measuring chain."""
