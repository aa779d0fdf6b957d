"""What joins rooms: capture then fit, through the file."""
