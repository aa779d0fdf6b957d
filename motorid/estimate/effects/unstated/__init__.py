"""What nobody states of a log's channels: it has a stated default, not nothing."""
