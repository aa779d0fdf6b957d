"""Which excitation reaches which uncertainty, in the shortest time. Pure: knows no board."""
