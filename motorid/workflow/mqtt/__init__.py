"""A station at an MQTT broker: its state, its verdicts until a consumer has them; docs/mqtt.md."""
