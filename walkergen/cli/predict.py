"""The command `predict`."""

from walkergen.cli import loading, show
from walkergen.cli import options as opt


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
    from walkergen.jobs.run.predict import make

    inputs = loading.inputs(
        keys, "design scene", restitution=restitution, friction=friction, law=law, gamma=gamma, frequency=frequency
    )
    chosen, resolved = inputs.design(design), inputs.scene(scene)
    checked = loading.mode_of(mode, resolved)
    members = inputs.members(chosen, tilt, legs, whole=False)
    masses = loading.weighed(weights, members, quiet=json)
    report = make.predict(chosen, members, resolved, checked, masses, uncertain)
    show.report(report, json, quiet=False)
