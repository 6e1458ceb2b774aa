"""`python -m walkergen`."""

from walkergen.cli import main

main()
