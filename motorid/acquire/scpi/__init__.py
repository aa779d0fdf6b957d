"""Rigs without a board of ours: a bench supply and what records beside it, over SCPI."""
