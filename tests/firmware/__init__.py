"""The portable firmware core and its port to this computer."""
