"""The motor's parameters and the response models that a fit evaluates."""
