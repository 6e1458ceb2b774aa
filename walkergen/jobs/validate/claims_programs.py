"""Claims against programs."""

from walkergen.jobs.validate.claim import Test

GROUP = "programs"
TESTS: tuple[Test, ...] = ()
