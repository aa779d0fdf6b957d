"""A station as a server of OPC UA: orders by a method, state, measurements; docs/opcua.md."""
