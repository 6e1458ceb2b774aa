"""What crowds do: films of many walkers in, statistics with errors from independent runs out."""

from walkergen.guests.crowd.statistics.film import CrowdFilm
from walkergen.guests.crowd.statistics.summary import CrowdStatistics, measure

__all__ = ["CrowdFilm", "CrowdStatistics", "measure"]
