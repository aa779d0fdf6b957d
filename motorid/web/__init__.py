"""Pages for a browser: the only room that listens for one."""
