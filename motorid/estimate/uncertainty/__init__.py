"""From a solution to standard uncertainties, budgets and intervals."""
