"""Request of `track`."""

from typing import TYPE_CHECKING

from walkergen.core.files.progress import Progress
from walkergen.guests.track.film.fields import TrackFields

if TYPE_CHECKING:
    from walkergen.guests.track.film.report import TrackReport


class TrackRequest(TrackFields):
    """Track walkers in a film from above: tracks.csv for analyse, and a picture to check.

    The walkers have one size, on a ground of another brightness, seen straight from above. Give the scale with
    --mm-per-px or --length. With --markers they carry caps. Their markers give number, place and heading, scale and
    tilt of the camera. With --lens the distortion of a lens is removed. Needs the extra film: pip install
    'walkergen[film]'.

    Examples
    --------
    The film shows three walkers of 28 mm.

    >>> import walkergen as wg
    >>> found = wg.track("film.mp4", length=28)
    >>> len(set(found.table["particle"]))
    3
    """

    def run(self, progress: Progress) -> "TrackReport":
        """Track the walkers, with or without markers, write the results, and return the report."""
        from walkergen.core.files import output
        from walkergen.guests.track.film import make

        return make.track(self, output.result_folder(self.film, self.out, "track"), progress)
