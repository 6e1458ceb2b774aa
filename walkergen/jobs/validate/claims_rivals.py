"""Claims against physics engines."""

from walkergen.jobs.validate.claim import Test

GROUP = "rivals"
TESTS: tuple[Test, ...] = ()
