"""The command `predict`."""

from typing import Any, NamedTuple

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli import uncertain as told


class Shares(NamedTuple):
    """Shares of a row's variance, for JSON; the field's name is its key."""

    shares: list[dict[str, Any]]


def predict(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    keys: opt.Values = None,
    weights: opt.WeightsFile = None,
    uncertain: opt.Uncertain = False,
    json: opt.AsJson = False,
) -> None:
    """Predict the speed of walkers, without writing any file.

    With --uncertain it says, for each, which input to measure next to narrow the bounds.
    """
    from walkergen.jobs.family import make as families
    from walkergen.theory import prediction
    from walkergen.walker import solids

    asked = loading.asked(
        keys, "design scene",
        restitution=restitution, friction=friction, law=law, gamma=gamma, frequency=frequency,
    )  # fmt: skip
    chosen, resolved = asked.design(design), asked.scene(scene)
    checked = loading.mode_of(mode, resolved)
    members = asked.members(chosen, tilt, legs, whole=False)
    built = [solids.build(member) for member in members]
    masses = loading.weighed(weights, members, quiet=json)
    made = list(families.predicted(members, built, resolved, checked, masses))
    (rows, _), weighed = families.rows_of(made), families.weighed_of(made)
    shares = [
        prediction.shares(one.design, one.mass, resolved, checked) for one in made if uncertain
    ]
    if json:
        listed = [Shares([share._asdict() for share in each]) for each in shares]
        show.rows_as_json(rows, weighed, listed)
        return
    assumed = families.caption(chosen, resolved, checked)
    show.predictions(rows, assumed, chosen.name, weighed=weighed)
    for one, each in zip(made, shares, strict=False):
        told.shares(each, f"{one.name}: share of the variance behind the bounds")
