"""The command line as a child of the page's server: it ends with it, and says how far it is."""

from walkergen import cli
from walkergen.app import children
from walkergen.cli import show

PAUSE_S = 0.5
"""Time (s) between two lines that say how far a job is: a page shows the last one."""

if __name__ == "__main__":
    children.listen()
    show.FIRST_S = show.NEXT_S = PAUSE_S
    cli.main()
