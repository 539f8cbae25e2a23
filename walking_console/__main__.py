"""``python -m walking_console``: the command line."""

from walking_console.server.cli import main

if __name__ == "__main__":
    main()
