"""A capture as the likelihood sees it: residuals, their weights, their correlation."""
