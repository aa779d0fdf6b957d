"""Captures: the model, the HDF5 store, readers of other people's files. Knows no port."""
