"""What instruments say of a rig's own readings, with uncertainty: pure, knows no port."""
