"""The bridge that makes the motor's voltage from a supply, where its voltage is not measured."""
