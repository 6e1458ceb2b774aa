"""Examples at the end of every command's help, without the word walkergen; tests parse them all."""

EXAMPLES: dict[str, tuple[str, str]] = {
    "app": ("app", "app my.toml --port 0"),
    "family": ("family", "family maker-large --tilt 5:20:5 --copies 4"),
    "export": ("export --tilt 12 --format stl,3mf", "export my.toml --tilt 10 --format mjcf"),
    "check": ("check", "check my.toml --tilt 5,10 --printer ender3"),
    "plate": ("plate --tilt 5,10,15 --copies 8", "plate --calibration --printer ender3"),
    "design": ("design --speed 80", "design --fastest --vary legs.length_mm=4:9"),
    "predict": ("predict --tilt 5:30:5", "predict my.toml --tilt 10 --weights weights.csv"),
    "sweep": ("sweep --set legs.tilt_deg=0:40:2", "sweep --set legs.tilt_deg=5,10 --set scene.drive.gamma=1:3:0.5"),
    "simulate": ("simulate --tilt 10", "simulate --tilt 10 --error 5%"),
    "crowd": (
        "crowd --count 30 --arena disc:120 --seconds 20",
        "crowd --count polar-disc:20,rotator:10 --arena periodic:200",
    ),
    "movie": ("movie --tilt 10", "movie --tilt 5,10,15 --scene plane-90hz"),
    "explain": ("explain --tilt 10", "explain --scene plane-noisy --no-cost"),
    "track": ("track film.mp4 --mm-per-px 0.1", "track film.mp4 --length 28 --heading mark --fps 240"),
    "analyse": (
        "analyse film.csv --fps 50 --mm-per-px 0.1",
        "analyse first.csv --run second.csv --dish disc:120 --body 24x8",
    ),
    "card": ("card koumakis2016 --scene plane-90hz", "card tracks.csv --design my.toml"),
    "fit": ("fit speeds.csv", "fit speeds.csv --predict 8,12"),
    "calibrate": ("calibrate measurements.csv", "calibrate measurements.csv --design my.toml --scene plane-90hz"),
    "bench": ("bench drop --measured 0.5", "bench slide --measured 14"),
    "bench drop": ("bench drop", "bench drop --measured 0.5 --tries 10"),
    "bench slide": ("bench slide", "bench slide --measured 14 --measured-sd 1"),
    "bench pluck": ("bench pluck", "bench pluck --measured 180 --decrement 0.2"),
    "weigh": ("weigh walker.stl", "weigh robot.3mf --density 1.27"),
    "accuracy": ("accuracy --budget 30s", "accuracy --tilt 10 --only models,steps"),
    "selftest": ("selftest", "selftest --only 6.7"),
    "reproduce": ("reproduce --tilt 5,10,20 --runs 8", "reproduce --gamma 1.5,1.8"),
    "templates": ("templates", "templates copy koumakis2016 my.toml"),
    "templates show": ("templates show lane-90hz", "templates show prusa-mk3s"),
    "templates copy": ("templates copy lane-90hz", "templates copy koumakis2016 my.toml"),
}
"""Two examples of each command, by its name; files in them are the user's own."""
