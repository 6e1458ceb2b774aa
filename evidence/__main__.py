"""The evidence, run from a checkout: `python -m evidence NAME`; `make evidence` runs all of it."""

import os


def main() -> None:
    """Run a command; Ctrl-C while it is loaded ends it as it does `walkergen`."""
    try:
        from evidence.commands import commands
        from walkergen import cli

        cli.main(commands)
    except KeyboardInterrupt:
        os._exit(130)


if __name__ == "__main__":
    main()
