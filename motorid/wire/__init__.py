"""The wire protocol: one spec, framing and codec. Pure: no port, no clock."""
