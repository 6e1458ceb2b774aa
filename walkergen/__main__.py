"""`python -m walkergen`, and the command `walkergen`."""

import gc
import os

GARBAGE = 50_000
"""Objects made between two searches for unused ones, 700 by default: libraries make as they load
many that stay, among which each search is in vain, a tenth of the time of a short command."""


def main() -> None:
    """Run the command line; Ctrl-C while it is loaded ends it with the same exit code as later."""
    gc.set_threshold(GARBAGE)
    try:
        from walkergen import cli

        cli.main()
    except KeyboardInterrupt:
        os._exit(130)  # by itself Python may die of the same signal, with no exit code


if __name__ == "__main__":
    main()
