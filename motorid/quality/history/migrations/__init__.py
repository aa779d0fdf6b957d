"""The steps by which the tables came to be what they are; Alembic carries them out.

A step, once released, never changes: it says in its own words which tables it makes, and imports
nothing of the present ones. Steps go forward only; the way back is a backup.
"""
