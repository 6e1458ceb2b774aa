"""Child of the server that simulates a second of a walker's run, for the page's viewer to play."""

import json
import sys

from walkergen.app import children
from walkergen.app.document import SOURCE, Document
from walkergen.errors import WalkergenError


def main() -> int:
    """Print the run of the document that the server sent, packed as JSON; returns the exit code."""
    document = Document(**children.listen())
    from walkergen.jobs.make.family import play

    try:
        print(json.dumps(play.run(document.design(), document.ground())))
    except WalkergenError as error:
        for line in str(error).splitlines():
            print(f"error: {line.removeprefix(f'{SOURCE}: ')}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
