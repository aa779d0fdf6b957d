"""What drives the motor: the source, the bridge, the brushes, the winding."""
