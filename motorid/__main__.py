"""``python -m motorid``: the same as the command ``motorid``."""

from motorid.cli.main import main

if __name__ == "__main__":
    main()
