"""When a reading is taken: delays, the clock, the stamps of a log."""
