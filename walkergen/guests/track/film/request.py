"""Request of `track`."""

from typing import TYPE_CHECKING

from walkergen.core.files.progress import Progress
from walkergen.guests.track.film.fields import TrackFields

if TYPE_CHECKING:
    from walkergen.guests.track.film.report import TrackReport


class TrackRequest(TrackFields):
    """Track walkers in a film from above: tracks.csv for analyse, and a picture to check.

    The walkers are of one size, on a ground of another brightness, seen straight from above. Give the scale by
    --mm-per-px or --length. With --markers the markers on caps give number, position and heading, the scale and the
    camera's tilt. --lens corrects lens distortion. Needs the extra film: pip install 'walkergen[film]'.
    """

    def run(self, progress: Progress) -> "TrackReport":
        """Track the walkers, with or without markers."""
        from walkergen.core.files import output
        from walkergen.guests.track.film import make

        return make.track(self, output.result_folder(self.film, self.out, "track"), progress)
