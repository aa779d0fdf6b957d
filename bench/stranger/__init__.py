"""A second bench of logs, which shares nothing with the others: drives, converters, clocks."""
