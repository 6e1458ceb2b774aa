"""Facts that the paper states, and the rule by which our number agrees with a fact or not.

Koumakis, Gnoli, Maggi, Puglisi, Di Leonardo, "Mechanism of self-propulsion in 3D-printed active
granular particles" (2016). Its figures hold more than its text, but our copy has lost them: only
what the text states in words or numbers is here.
"""

import math
from typing import Literal, NamedTuple

TIMES = 3.0
"""Standard errors by which two numbers may differ by chance. Of some twenty facts with errors two
would leave one out; of means of eight runs (Student's t) three leave out one in fifty."""


class Fact(NamedTuple):
    """Statement of the paper with which a number can be compared."""

    key: str
    figure: int
    quote: str
    where: str
    quantity: str
    """Name of the number that is compared with the statement."""
    unit: str
    value: float
    """Stated value; a bound where only one of `low` and `high` is finite."""
    low: float
    high: float
    """Upper end of the range from `low` that counts as agreement."""
    margin: str
    """Origin of `low` and `high`: "stated", or our reading of the words."""

    @property
    def bound(self) -> bool:
        """True when the paper states a limit, not a value."""
        return math.isinf(self.low) or math.isinf(self.high)

    @property
    def claim(self) -> str:
        """Stated value and margin in a few characters."""
        unit = f" {self.unit}" if self.unit else ""
        if math.isinf(self.low):
            return f"< {self.value:g}{unit}"
        if math.isinf(self.high):
            return f"> {self.value:g}{unit}"
        if math.isclose(self.high - self.value, self.value - self.low):
            return f"{self.value:g} ± {self.high - self.value:.3g}{unit}"
        return f"{self.value:g} ({self.low:.2g} to {self.high:.2g}){unit}"


FACTS = {
    fact.key: fact
    for fact in (
        Fact(
            "plate speed",
            2,
            "a vibration frequency set to 90 Hz and a maximum acceleration of 1.8 g corresponding "
            "to a maximum plate speed of 32 mm s-1",
            "text on figure 2, experiments",
            "peak speed of the plate",
            "mm/s",
            32.0,
            31.5,
            32.5,
            "our reading: the last digit stated",
        ),
        Fact(
            "friction",
            2,
            "e = 0.8 ± 0.1 and μ = 0.25 ± 0.02 which compare well with the best fit values",
            "text on figure 2, experiments",
            "friction",
            "",
            0.25,
            0.23,
            0.27,
            "stated",
        ),
        Fact(
            "restitution",
            2,
            "By directly observing structures bouncing and sliding on the surface we can estimate "
            "both the restitution and dynamic friction coefficients and obtain e = 0.8 ± 0.1",
            "text on figure 2, experiments",
            "restitution with which the peak is 60 mm/s",
            "",
            0.8,
            0.7,
            0.9,
            "stated",
        ),
        Fact(
            "peak tilt",
            2,
            "flexible objects run with an average speed that shows a prominent peak at a tilt "
            "angle around 10°, in good agreement with theoretical predictions",
            "text on figure 2, experiments",
            "tilt of the largest speed",
            "deg",
            10.0,
            7.5,
            12.5,
            "our reading of 'around': 2.5 deg",
        ),
        Fact(
            "peak speed",
            2,
            "our structures can run at a top speed of 60 mm s-1, a value that is twice as large "
            "as the maximum plate speed",
            "text on figure 2, experiments",
            "largest speed over the tilts",
            "mm/s",
            60.0,
            55.0,
            65.0,
            "our reading: 60 stated to about one digit",
        ),
        Fact(
            "speed at 10 deg",
            2,
            "a prominent peak at a tilt angle around 10° ... a top speed of 60 mm s-1",
            "text on figure 2, experiments",
            "speed at 10 deg",
            "mm/s",
            60.0,
            55.0,
            65.0,
            "our reading: 60 stated to about one digit",
        ),
        Fact(
            "maximum below",
            2,
            "displays a maximum that is always below 10° in a wide range of realistic values for e and μ",
            "text after equation 15, theory",
            "tilt of the largest speed",
            "deg",
            10.0,
            -math.inf,
            10.0,
            "stated",
        ),
        Fact(
            "15 below 10",
            2,
            "10°, 15°, 35° corresponding to high, medium and low propulsion efficiency",
            "text on figure 6, experiments",
            "speed at 15 deg over that at 10 deg",
            "",
            1.0,
            -math.inf,
            1.0,
            "stated",
        ),
        Fact(
            "35 below 15",
            2,
            "10°, 15°, 35° corresponding to high, medium and low propulsion efficiency",
            "text on figure 6, experiments",
            "speed at 35 deg over that at 15 deg",
            "",
            1.0,
            -math.inf,
            1.0,
            "stated",
        ),
        Fact(
            "braced",
            2,
            "rigid objects do not show a significant net propulsion",
            "text on figure 2, experiments",
            "largest speed of braced walkers, either way",
            "mm/s",
            0.0,
            -3.0,
            3.0,
            "our reading of 'significant': 5 % of 60 mm/s",
        ),
        Fact(
            "impact speed",
            2,
            "v_y^0 that we assumed to be of the same order of the maximum vertical speed of the "
            "plate but it actually fluctuates at each collision",
            "text after figure 3, theory",
            "impact speed over the plate's peak speed",
            "",
            1.0,
            10**-0.5,
            10**0.5,
            "our reading of 'order': half a decade",
        ),
        Fact(
            "types II and III",
            3,
            "The sum of type III and type II collisions account for more then 95% of events",
            "text on figure 4, simulations",
            "smallest share of types II and III over the tilts",
            "%",
            95.0,
            95.0,
            math.inf,
            "stated",
        ),
        Fact(
            "mostly type III",
            3,
            "throughout the range of φ values, the majority of collisions are of type III",
            "text on figure 4, simulations",
            "smallest share of type III over the tilts",
            "%",
            50.0,
            50.0,
            math.inf,
            "stated ('majority')",
        ),
        Fact(
            "proportional",
            5,
            "a good linear behaviour of the propulsion speed when plotted as a function of the "
            "plate speed ... the line is a linear fit passing through zero",
            "text on and caption of figure 5, experiments",
            "rms distance from a line through zero over the mean speed",
            "%",
            10.0,
            -math.inf,
            10.0,
            "our reading of 'good': 10 %",
        ),
        Fact(
            "ballistic at 10",
            6,
            "The fast and medium runner (φ = 10° and 15°) are practically always ballistic in the "
            "accessible time window",
            "text on figure 6, experiments",
            "smallest local exponent of the MSD at 10 deg",
            "",
            2.0,
            1.8,
            2.2,
            "our reading of 'practically': 10 %",
        ),
        Fact(
            "ballistic at 15",
            6,
            "The fast and medium runner (φ = 10° and 15°) are practically always ballistic in the "
            "accessible time window",
            "text on figure 6, experiments",
            "smallest local exponent of the MSD at 15 deg",
            "",
            2.0,
            1.8,
            2.2,
            "our reading of 'practically': 10 %",
        ),
        Fact(
            "superdiffusive at 35",
            6,
            "the slow one displays a transition from a superdiffusive to a diffusive regime",
            "text on figure 6, experiments",
            "local exponent of the MSD at 35 deg and 40 ms",
            "",
            1.0,
            1.0,
            math.inf,
            "stated ('superdiffusive')",
        ),
        Fact(
            "diffusive at 35",
            6,
            "the slow one displays a transition from a superdiffusive to a diffusive regime at t ~ 1.0 s",
            "text on figure 6, experiments",
            "exponent of the MSD at 35 deg beyond 1 s",
            "",
            1.0,
            0.8,
            1.2,
            "our reading of 'diffusive': 0.2",
        ),
        Fact(
            "crossover at 35",
            6,
            "the slow one displays a transition from a superdiffusive to a diffusive regime at t ~ 1.0 s",
            "text on figure 6, experiments",
            "lag at which the exponent at 35 deg falls to 1.5",
            "s",
            1.0,
            10**-0.5,
            10**0.5,
            "our reading of '~': half a decade",
        ),
    )
}

Word = Literal["agrees", "agrees within", "differs by", "undecided", "not measured"]


class Verdict(NamedTuple):
    """Relation of our number to a fact."""

    word: Word
    by: float | None
    """Distance from the stated value; from the bound, where the paper states a bound."""
    unit: str

    @property
    def agrees(self) -> bool:
        """True where our number agrees with the fact."""
        return self.word in ("agrees", "agrees within")

    def __str__(self) -> str:
        if not self.by or self.word in ("agrees", "not measured"):
            return self.word
        word = "undecided: off by" if self.word == "undecided" else self.word
        by = f"{self.by:.0f}" if self.by >= 10.0 else f"{self.by:.2g}"
        return f"{word} {by} {self.unit}".rstrip()


def judge(fact: Fact, ours: float | None, se: float | None) -> Verdict:
    """Compare a number and its standard error with a fact.

    It agrees when all of ours ± TIMES errors lies within the fact's margin, differs when none of
    it does, and is undecided in between or without an error bar: noise never makes an agreement.
    "agrees within x": not the stated value itself, but x from it.
    """
    if ours is None:
        return Verdict("not measured", None, fact.unit)
    limit = max(fact.low - ours, ours - fact.high, 0.0)
    by = limit if fact.bound else abs(ours - fact.value)
    if se is None:
        return Verdict("undecided", by, fact.unit)
    low, high = ours - TIMES * se, ours + TIMES * se
    if high < fact.low or low > fact.high:
        return Verdict("differs by", by, fact.unit)
    if not (fact.low <= low and high <= fact.high):
        return Verdict("undecided", by, fact.unit)
    exact = fact.bound or by <= TIMES * se or by <= 1e-9 * abs(fact.value)
    return Verdict("agrees" if exact else "agrees within", by, fact.unit)
