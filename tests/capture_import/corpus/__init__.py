"""Files as students, instruments and other libraries write them, each a log of one known motor."""
