"""The supply chain: the lock of what is installed, its licences, its bill of materials."""
