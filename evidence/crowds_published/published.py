"""Statements of published work on crowds of walkers, each with what was read of its source.

A number stands here only where the part of the source that states it was open before us; of the
rest only the sign is claimed: which way it goes. No source was open beyond the part named.
"""

from typing import NamedTuple


class Source(NamedTuple):
    """Published work, and how much of it was read for this table."""

    citation: str
    address: str
    read: str
    """Part that was read; the claims are from nowhere else."""


class Finding(NamedTuple):
    """One statement of published work on crowds."""

    key: str
    source: Source
    quote: str
    """Words of the source."""
    sign: str
    """What should come out if the same holds of our walkers, without a number."""
    values: tuple[float, ...] = ()
    """Numbers that the part read states; none where only the sign is known."""
    unit: str = ""

    @property
    def stated(self) -> str:
        """The numbers as the table shows them, or that there is the sign alone."""
        numbers = ", ".join(f"{value:g}" for value in self.values)
        return f"{numbers} {self.unit}".strip() if numbers else "sign only"


KUMAR = Source(
    "Kumar, Soni, Ramaswamy, Sood, Flocking at a distance in active granular matter, "
    "Nature Communications 5, 4688 (2014)",
    "https://www.nature.com/articles/ncomms5688",
    "abstract and introduction",
)
DISSENTERS = Source(
    "Motile dissenters disrupt the flocking of active granular matter",
    "https://shamra-academia.com/show/3a440cb150faba/amp",
    "abstract (authors and journal not seen)",
)
VIBRATORS = Source(
    "Chen, Zhang, Clusters and collective motions in Brownian vibrators, arXiv 2301.06377 (2023); "
    "Anomalous large-scale collective motion in granular Brownian vibrators, arXiv 2308.04219",
    "https://arxiv.org/abs/2301.06377",
    "abstracts",
)
CAPRINI = Source(
    "Caprini, Breoni, Ldov, Scholz, Löwen, Dynamical clustering and wetting phenomena in inertial "
    "active matter, Communications Physics (2024), arXiv 2406.01038",
    "https://www.nature.com/articles/s42005-024-01835-y",
    "abstract of both, and the beginning of the introduction",
)
GIOMI = Source(
    "Giomi, Hawley-Weld, Mahadevan, Swarming, swirling and stasis in sequestered bristle-bots, "
    "Proceedings of the Royal Society A 469, 20120637 (2013), arXiv 1302.5952",
    "https://arxiv.org/abs/1302.5952",
    "abstract and the beginning of the introduction",
)
DESEIGNE = Source(
    "Deseigne, Dauchot, Chaté, Collective motion of vibrated polar disks, "
    "Physical Review Letters 105, 098001 (2010), arXiv 1004.1499",
    "https://arxiv.org/abs/1004.1499",
    "abstract",
)
BINARY = Source(
    "Deseigne, Léonard, Dauchot, Chaté, Vibrated polar disks: spontaneous motion, binary "
    "collisions, and collective dynamics, Soft Matter (2012), arXiv 1201.6021",
    "https://arxiv.org/abs/1201.6021",
    "abstract",
)
WEBER = Source(
    "Weber, Hanke, Deseigne, Léonard, Dauchot, Frey, Chaté, Long-range ordering of vibrated polar "
    "disks, Physical Review Letters 110, 208001 (2013), arXiv 1304.4760",
    "https://arxiv.org/abs/1304.4760",
    "abstract",
)
DELAY = Source(
    "Scholz, Jahanshahi, Ldov, Löwen, Inertial delay of self-propelled particles, "
    "Nature Communications 9, 5156 (2018), arXiv 1807.04357",
    "https://www.nature.com/articles/s41467-018-07596-x",
    "abstract and introduction",
)
ROTORS = Source(
    "Scholz, Engel, Pöschel, Rotating robots move collectively and self-organize, Nature Communications 9 (2018)",
    "https://www.nature.com/articles/s41467-018-03154-7",
    "abstract and introduction",
)

FINDINGS = {
    finding.key: finding
    for finding in (
        Finding(
            "one rod",
            KUMAR,
            "A single such motile rod on a bare vibrated surface translates, with mean speed "
            "0.36 cm s-1 and standard deviation 0.25 cm s-1, where the statistics is obtained from "
            "150 rods",
            "a walker alone runs with its thin end or heading ahead, and walkers differ",
            (3.6, 2.5),
            "mm/s",
        ),
        Finding(
            "flock by medium",
            KUMAR,
            "undergo a phase transition to a state of spontaneous alignment of velocities and "
            "orientations above a threshold bead area fraction",
            "order needs beads between few rods",
        ),
        Finding(
            "tapered rods",
            DISSENTERS,
            "The system undergoes the flocking phase transition at a threshold area fraction "
            "~ 0.12 having high orientational correlations between the particles. However, the "
            "one-step-tapered rods do not flock",
            "polar order rises with packing for one shape of rod, for another not",
            (0.12,),
        ),
        Finding(
            "brownian vibrators",
            VIBRATORS,
            "The collective motion emerges near φ=0.317, where the most significant clusters span "
            "half of the system, and disappears near φ=0.713, around which the system crystallizes",
            "velocities of neighbours agree between two packings, not below and not above",
            (0.317, 0.713),
        ),
        Finding(
            "frequency",
            CAPRINI,
            "inertia can be systematically tuned by changing the shaker frequency ... Before the "
            "suppression of clustering, inertia induces a transition in the cluster's inner "
            "structure",
            "clusters at one end of the frequencies, none at the other, where inertia is larger",
        ),
        Finding(
            "walls",
            CAPRINI,
            "in an underdamped inertial active system, walls do not favor cluster formation",
            "walkers with much inertia do not gather at the wall",
        ),
        Finding(
            "swirl or stasis",
            GIOMI,
            "increasing the density drives a transition from a disordered and uncoordinated motion "
            "to organized collective motion either as a swirling cluster or a collective dynamical "
            "stasis. This transition is regulated by a single parameter, the relative magnitude of "
            "spinning and walking in a single automaton",
            "walkers that spin more circulate more about the dish, those that spin less stand more",
        ),
        Finding(
            "polar discs",
            DESEIGNE,
            "Varying the amplitude of the vibration, we observe the onset of large-scale collective motion",
            "polar order rises with the amplitude of the plate",
        ),
        Finding(
            "two discs",
            BINARY,
            "binary collisions are spatiotemporally extended events during which multiple actual "
            "collisions happen, yielding a weak average effective alignment",
            "a meeting of two walkers is many contacts, and aligns them little",
        ),
        Finding(
            "long range",
            WEBER,
            "Using system sizes not accessible in the laboratory, we show in silico that true "
            "long-range order is possible in the experimental system",
            "order grows with the number of walkers",
        ),
        Finding(
            "delay",
            DELAY,
            "We observe a distinct inertial delay between orientation and velocity of particles",
            "the velocity's direction lags behind the heading",
        ),
        Finding(
            "rotors",
            ROTORS,
            "rotors move collectively and exhibit super-diffusive interfacial motion and phase "
            "separate via spinodal decomposition",
            "walkers that turn left and right part from each other",
        ),
    )
}
"""Statements by key. Their numbers are of other grains than ours, which no number of ours can
contradict: what is compared is the sign."""
