"""Where captures are kept: files, an object store, packs. ``captures`` is the door for readers."""
