"""Facts of rig, board, program, nameplate and import, compared with the data and one another."""
