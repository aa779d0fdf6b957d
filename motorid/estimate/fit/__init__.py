"""The joint fit: start values, search, alternation with the source, assembly of the estimate."""
