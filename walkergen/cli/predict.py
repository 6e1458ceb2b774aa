"""The command `predict`."""

from walkergen.cli import options as opt
from walkergen.cli import show


def predict(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    weights: opt.WeightsFile = None,
    json: opt.AsJson = False,
) -> None:
    """Predict the speed of walkers, without writing any file."""
    from walkergen.jobs.family import make as families
    from walkergen.walker import solids
    from walkergen.walker import weights as balance

    chosen = opt.design_of(design)
    changes = opt.Changes(restitution=restitution, friction=friction, law=law)
    resolved = opt.scene_of(scene, changes)
    checked = opt.mode_of(mode, resolved)
    members = opt.members_of(chosen, tilt, legs, whole=False)
    built = [solids.build(member) for member in members]
    masses = {} if weights is None else balance.read(weights, members)
    made = list(families.predicted(members, built, resolved, checked, masses))
    (rows, _), weighed = families.rows_of(made), families.weighed_of(made)
    if json:
        show.rows_as_json(rows, weighed)
    else:
        told = families.caption(resolved, checked)
        show.predictions(rows, told, chosen.name, weighed=weighed)
