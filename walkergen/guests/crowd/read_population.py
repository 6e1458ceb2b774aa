"""Population of a crowd from its request: designs or cards, their numbers, and the scene.

`sources`: designs or cards, as objects or files. `given`: reads designs and scene with the request's settings.
"""

from pathlib import Path
from typing import Any

from walkergen.core import Design, InputError, Scene
from walkergen.guests.crowd import in_plane, in_space, walker_counts
from walkergen.guests.crowd.cards import card
from walkergen.guests.crowd.population import Population
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.inputs import Inputs
from walkergen.request import PAPER_WALKER, PLANE_SCENE, choose_scene


def read_population(request: CrowdRequest) -> Population:
    """Read the files that a request names, and return its population. Raises InputError."""
    by_name = request.count if isinstance(request.count, dict) else {}
    counts = list(by_name.values()) or None
    if counts is not None and request.design is not None:
        shown = ",".join(f"{name}:{count}" for name, count in by_name.items())
        raise InputError(f"‹count=›{shown[:60]}: already names the designs. Leave ‹design› out.", "count")
    total = sum(counts) if counts else request.count
    given = request.inputs({} if total is None else {"scene.crowd.count": ("count", total)})
    sources = list(request.count) if isinstance(request.count, dict) else [request.design or PAPER_WALKER]
    designs = [] if _is_flat(request, sources) else _load_designs(request, given, sources)
    ground = choose_scene(request.scene, designs, PLANE_SCENE)
    scene = given.scene(ground, {"scene.run.runs": walker_counts.DEFAULT_RUNS})
    if designs:
        return in_space.make_population(request, scene, designs, counts)
    return _make_flat_population(request, given, scene, sources, counts)


def _is_flat(request: CrowdRequest, sources: list[Any]) -> bool:
    """Return whether all sources are cards. Raises InputError for a mixture, or sources that the model cannot use."""
    cards = [is_card(source) for source in sources]
    if all(cards) and request.model != "space":
        return True
    if any(cards):
        name = sources[cards.index(True)]
        remedy = "Give only designs, or only cards" if not all(cards) else "Write ‹model=›flat, or give a design"
        raise InputError(f"{name}: is a card, which only ‹model=›flat supports. {remedy}.")
    if request.model == "flat" or request.write_only:
        flag = "‹model=›flat" if request.model == "flat" else "‹write_only›"
        raise InputError(
            f"{flag}: needs a card of {sources[0]}. Run `walkergen crowd {sources[0]} --card`, then give the path "
            "of its card.json as ‹design›.",
            "model",
        )
    return False


def is_card(source: Any) -> bool:
    """Return whether a source is a card or the path of one (.json)."""
    return isinstance(source, card.Card) or (isinstance(source, (str, Path)) and str(source).lower().endswith(".json"))


def _load_designs(request: CrowdRequest, given: Inputs, sources: list[Any]) -> list[Design]:
    """Load the designs in `sources`, with the request's settings. Raises InputError for a tilt of several designs."""
    if len(sources) > 1:
        request.check_unset(f"is for one design, not for {len(sources)}", "tilt", "legs")
        return [given.design(source) for source in sources]
    return [given.single_member(sources[0], request.tilt, request.legs)]


def _make_flat_population(
    request: CrowdRequest, given: Inputs, scene: Scene, sources: list[Any], counts: list[int] | None
) -> Population:
    """Return a population of the cards (objects or files) in `sources`. Raises InputError for keys that cards fix."""
    why = "is fixed by the card. Measure another card (‹card›)"
    request.check_unset(why, "tilt", "legs")
    settled = [key for key in given.values if not key.startswith(("scene.crowd.", "scene.run."))]
    given.check_unset([*settled, "scene.run.step_us"], f"{why}, or leave it out.")
    cards = [card.read_card(Path(source)) if isinstance(source, (str, Path)) else source for source in sources]
    return in_plane.make_population(request, scene, cards, counts)
