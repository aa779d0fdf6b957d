"""Logs of others: what nobody stated of their channels, tried one after the other."""
