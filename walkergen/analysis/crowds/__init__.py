"""What crowds do: films of many walkers in, statistics with errors from independent runs out."""

from walkergen.analysis.crowds.film import CrowdFilm
from walkergen.analysis.crowds.measuring import CrowdStatistics, measure

__all__ = ["CrowdFilm", "CrowdStatistics", "measure"]
