"""`python -m walkergen`, and the command `walkergen`."""

import os


def main() -> None:
    """Run the command line. Ctrl-C during its import exits with the same code, 130, as later."""
    try:
        from walkergen import cli

        cli.main()
    except KeyboardInterrupt:
        os._exit(130)  # otherwise Python may die of the same signal, with no exit code


if __name__ == "__main__":
    main()
