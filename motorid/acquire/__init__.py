"""From a port to a capture file: port, board client, journal, record."""
