"""Crowd statistics: from films of many walkers to numbers with errors from independent runs."""

from walkergen.guests.crowd.statistics.film import CrowdFilm
from walkergen.guests.crowd.statistics.summary import CrowdStatistics, measure

__all__ = ["CrowdFilm", "CrowdStatistics", "measure"]
