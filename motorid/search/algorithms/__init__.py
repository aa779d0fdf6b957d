"""The population searches, a family each."""
