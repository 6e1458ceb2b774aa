"""`python -m walkergen`, and the command `walkergen`."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C while it is loaded ends it as quietly as later."""
    try:
        from walkergen import cli

        cli.main()
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
