"""What simulated fits rest on: likelihood, posterior, lessons, what is kept, what is refused."""

import numpy as np
import pytest
from scipy import stats

from walkergen.core.errors import InputError
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import PAPER_CONTACT, Scene
from walkergen.core.theory.uncertain_inputs import Input
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import emulated_speeds, identifiability, importance_sampling, parameters, posterior
from walkergen.guests.lab.fit.emulated_speeds import Response
from walkergen.guests.lab.fit.parameters import Parameter, prior_values
from walkergen.guests.lab.fit.posterior import Observed

THREE = (
    Parameter("restitution", Input("contact.restitution", 0.5, 0.29, 0.0, 1.0), True),
    Parameter("friction", Input("contact.friction", 0.3, 0.17, 0.02, 0.6), True),
    Parameter("damping_ratio", Input("legs.damping_ratio", 0.05, 0.02), False),
)


def silent(what, done, total):
    pass


def setting(tilt=10.0):
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=tilt)
    return emulated_speeds.Setting(design, 31.2)


def speed_of(x, number):
    """Smooth stand-ins for the simulator: speeds (mm/s) in settings told apart by a number."""
    e, mu = x[:, 0], x[:, 1]
    return 20.0 + (70.0 - 8.0 * number) * e * np.exp(-((mu - 0.1 * number) ** 2) / 0.08)


def responses(count, numbers, scatter=0.12, function=speed_of):
    """Responses to noisy prints of the stand-ins."""
    from scipy.stats import qmc

    found = []
    for number in numbers:
        rng = np.random.default_rng(number)
        x = prior_values(THREE, qmc.Sobol(3, rng=rng).random(count))
        speed = function(x, number)
        speed = speed * (1.0 + scatter * rng.normal(size=count))
        found.append(emulated_speeds.fit_response(x, speed, setting(), scatter > 0))
    return found


def exact(mean, sd, scatter):
    """Response that is known: `mean` and `sd` as functions of x, scatter over speed."""

    class Known:
        centre = np.zeros(3)

        def __call__(self, x):
            return mean(x), sd(x)

    return Response(Known(), 0.0, scatter, 3.0)


def test_the_likelihood_is_that_of_normal_prints_with_a_common_error():
    rng = np.random.default_rng(1)
    x = rng.uniform(0.1, 0.9, (5, 3))
    response = exact(lambda x: 40.0 + 30.0 * x[:, 0], lambda x: 2.0 + 3.0 * x[:, 1], 0.1)
    seen = Observed(np.array([50.0, 61.0, 57.0]), np.array([1.0, 2.0, 0.5]))
    found, chi2 = posterior.log_likelihood(x, [seen], [response])
    mean, sd = response.emulator(x)
    for place in range(5):
        own = np.diag(seen.se**2 + (0.1 * mean[place]) ** 2)
        rival = stats.multivariate_normal(np.full(3, mean[place]), own + sd[place] ** 2)
        expected = rival.logpdf(seen.speed) + 1.5 * np.log(2.0 * np.pi)
        assert found[place] == pytest.approx(expected, rel=1e-10)
        residual = seen.speed - mean[place]
        assert chi2[place] == pytest.approx(residual @ np.linalg.solve(rival.cov, residual))


def test_scatter_between_prints_is_found_with_its_growth():
    rng = np.random.default_rng(3)
    speed = rng.uniform(0.0, 100.0, 4000)
    residual = np.hypot(3.0, 0.1 * speed) * rng.normal(size=4000)
    # Standard deviations of 4000 values are known to 1 %, parts of them to a few percent.
    assert emulated_speeds._fit_scatter(speed, residual) == pytest.approx((3.0, 0.1), rel=0.1)


def test_without_information_the_posterior_is_the_prior():
    seen = [Observed(np.array([50.0]), np.array([1e9]))]
    found = importance_sampling.sample(THREE, seen, responses(64, [1]), 1, silent)
    rows = identifiability.summarise_draws(THREE, found.draws)
    # Some 2000 independent draws know a standard deviation to 2 %.
    assert [row.narrowed for row in rows] == pytest.approx([1.0] * 3, abs=0.08)
    (note,) = identifiability.unlearnt_notes(rows)
    assert "restitution, friction and damping_ratio" in note
    assert found.independent > 1000
    assert identifiability.trade_off_notes(THREE, found.draws) == []
    assert np.array_equal(importance_sampling.sample(THREE, seen, responses(64, [1]), 1, silent).draws, found.draws)


@pytest.mark.parametrize(("shift", "disagrees"), [(1.0, False), (4.0, True)])
def test_measurements_that_speeds_contradict_are_named(shift, disagrees):
    # A normal prior p ± s and speeds that alone give p + shift * hypot(s, s) ± s give the fit p + shift s / sqrt(2)
    friction = Parameter("friction", Input("contact.friction", 0.3, 0.02), False)
    fitted = 0.3 + shift * 0.02 / np.sqrt(2.0)
    draws = np.random.default_rng(1).normal(fitted, 0.02 / np.sqrt(2.0), (4000, 1))
    (row,) = identifiability.summarise_draws([friction], draws)
    assert identifiability.disagreements([friction], [row]) == []  # it is assumed
    found = identifiability.disagreements([friction], [row._replace(measured=True)])
    assert len(found) == disagrees
    if disagrees:
        assert found[0].startswith("speeds and the measured friction disagree: ")
        assert f"by {shift:.1f} times" in found[0]


def test_values_without_a_stated_deviation_are_assumed():
    given = {"friction": 0.31, "friction_sd": 0.02, "restitution": 0.6}
    scene, design = Scene(contact=given), Design()
    assert parameters.is_measured("friction", scene, design)
    assert not parameters.is_measured("restitution", scene, design)
    assert not parameters.is_measured("thickness_mm", scene, design)


def test_a_speed_far_from_the_fit_is_named_as_outlier():
    (note,) = identifiability.outlier_notes([40.0, 80.0], [42.0, 42.0], [5.0, 5.0], np.array([10.0, 20.0]))
    assert note.startswith("outlier: the row of 20 deg and 80 mm/s lies 7.6 standard deviations")


@pytest.mark.nightly
def test_a_product_that_alone_is_known_is_named():
    def product(x, number):
        return 400.0 * x[:, 0] * x[:, 1]

    seen = [Observed(np.array([50.0]), np.array([1.0]))]
    known = responses(128, [1], 0.0, product)
    found = importance_sampling.sample(THREE, seen, known, 1, silent)
    (note,) = identifiability.trade_off_notes(THREE, found.draws)
    assert "restitution and friction trade off" in note or "friction and restitution trade off" in note
    power = float(note.split("^")[1].split(" ")[0])
    assert power == pytest.approx(1.0, abs=0.25)  # 1 for a product, -1 for a ratio
    (note,) = identifiability.unlearnt_notes(identifiability.summarise_draws(THREE, found.draws))
    assert "damping_ratio" in note


@pytest.mark.nightly
def test_speeds_that_no_parameters_explain_are_called_so():
    known = responses(64, [1], 0.0)
    seen = [Observed(np.array([300.0, 310.0]), np.array([1.0, 1.0]))]
    found = importance_sampling.sample(THREE, seen, known, 1, silent)
    (note,) = identifiability.misfit_notes(found, 2, "space")
    assert "does not describe these speeds" in note
    fair = [Observed(np.array([50.0, 51.0]), np.array([1.0, 1.0]))]
    assert identifiability.misfit_notes(importance_sampling.sample(THREE, fair, known, 1, silent), 2, "space") == []


@pytest.mark.nightly
@pytest.mark.parametrize("measured", [pytest.param((0, 2, 4), id="three"), pytest.param((1, 3), id="two")])
def test_ninety_percent_of_prints_not_measured_lie_in_the_ninety_percent_band(measured):
    known = responses(64, range(5))
    rng = np.random.default_rng(len(measured))
    inside = []
    for _ in range(30):
        x = prior_values(THREE, rng.uniform(size=(1, 3)))
        speed = np.array([float(speed_of(x, number)[0]) for number in range(5)])
        prints = speed * (1.0 + 0.12 * rng.normal(size=5))
        film = prints + 1.5 * rng.normal(size=5)
        seen = [Observed(film[[one]], np.array([1.5])) for one in measured]
        mine = [known[one] for one in measured]
        found = importance_sampling.sample(THREE, seen, mine, 1, silent)
        for one in set(range(5)) - set(measured):
            low, high = np.quantile(posterior.speed_draws(found.draws, known[one], rng), (0.05, 0.95))
            inside.append(low <= prints[one] <= high)
    # Three standard deviations of a binomial share of 60 or 90.
    assert abs(np.mean(inside) - 0.9) < 3.0 * np.sqrt(0.09 / len(inside)), np.mean(inside)


@pytest.fixture
def ground():
    scene = templates.load("lane-90hz", "scenes", Scene)
    design = templates.load("koumakis2016", "walkers", Design)
    unknown = parameters.list_unknowns(scene, design, "space", "flat", {})
    return emulated_speeds.FitInputs(scene, "space", unknown)


def test_runs_done_before_ctrl_c_are_not_done_again(ground, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x = emulated_speeds.sample_parameters(ground, 8)
    asked_for = []

    class Found:
        def __init__(self, speed):
            self.summary = type("Summary", (), {"speed": Quantity("speed", "mm_s", speed)})

    def until_third(asked, progress):
        first = not asked_for
        asked_for.extend(asked)
        done = {number: Found(None if number == 1 else number + 1.0) for number in range(len(asked))}
        return {number: done[number] for number in range(3)} if first else done

    monkeypatch.setattr(emulated_speeds.walkers, "simulate_parallel", until_third)
    with pytest.raises(KeyboardInterrupt):
        emulated_speeds.simulate(ground, setting(), x, silent, 0)
    speeds = emulated_speeds.simulate(ground, setting(), x, silent, 0)
    assert len(asked_for) == 8 + 5
    assert speeds[[0, 2]] == pytest.approx([1.0, 3.0])
    assert np.isnan(speeds[1])


def test_prints_of_two_settings_are_independent_and_of_one_repeatable(ground):
    one, again = (emulated_speeds._sample_prints(ground, setting(10.0), 8, 0) for _ in range(2))
    other, later = (
        emulated_speeds._sample_prints(ground, setting(12.0), 8, 0),
        emulated_speeds._sample_prints(ground, setting(10.0), 8, 1),
    )
    assert np.array_equal(one[0], again[0])
    assert one[1] == again[1]
    for different in (other, later):
        assert not np.any(one[0] == different[0])
        assert not set(one[1]) & set(different[1])


def test_walkers_that_fall_are_left_out_and_too_many_refused():
    x = prior_values(THREE, np.random.default_rng(2).uniform(size=(32, 3)))
    speed = speed_of(x, 1)
    speed[:8] = np.nan
    found = emulated_speeds.fit_response(x, speed, setting(), False)
    assert found(x)[0] == pytest.approx(speed_of(x, 1), abs=3.0)
    speed[8] = np.nan
    with pytest.raises(emulated_speeds.InputError, match="9 of 32 simulated walkers have no speed"):
        emulated_speeds.fit_response(x, speed, setting(), False)


def test_priors_are_flat_or_the_scenes_and_held_values_leave_no_parameter():
    scene = templates.load("plane-90hz", "scenes", Scene)
    design = templates.load("koumakis2016", "walkers", Design)
    flat = parameters.list_unknowns(scene, design, "space", "flat", {})
    assert [one.statement for one in flat.parameters] == [
        "flat, 0.02 to 1",
        "flat, 0.02 to 0.6",
        "5, factor 2",
        "0.4 ± 0.02",
        "3 ± 0.35",
        "0.05 ± 0.02",
    ]
    assert flat.prints_differ
    told = parameters.list_unknowns(scene, design, "space", "scene", {"friction": 0.25})
    assert [one.statement for one in told.parameters][:2] == [
        f"{PAPER_CONTACT.restitution:g} ± {PAPER_CONTACT.restitution_sd:g}",
        "5, factor 2",
    ]
    assert flat.parameters == flat.simulated
    alone = parameters.list_unknowns(scene, design, "prediction", "flat", {}, has_se=False)
    assert alone.parameters[-1].name == "print_scatter"
    everything = dict.fromkeys(parameters.PARAMETER_KEYS, 0.3)
    with pytest.raises(parameters.InputError, match="no parameter is left to fit"):
        parameters.list_unknowns(scene, design, "space", "flat", everything)


def test_another_plate_speed_keeps_the_frequency_and_the_ground_has_no_end(ground):
    arena = ground.scene.arena.model_copy(update={"length_mm": 100.0})
    there = ground._replace(scene=ground.scene.model_copy(update={"arena": arena}))
    scene = emulated_speeds._short_scene(there, setting()._replace(plate_speed=40.0))
    assert scene.drive.peak_speed == pytest.approx(40.0)
    assert scene.drive.frequency == pytest.approx(ground.scene.drive.frequency)
    assert scene.arena.length_mm is None
    own = emulated_speeds._short_scene(there, setting()._replace(plate_speed=there.scene.drive.peak_speed))
    assert own.drive == there.scene.drive


@pytest.mark.parametrize(("speeds", "name"), [((50.0, 51.0, 400.0), "400"), ((-300.0, 50.0, 51.0), "-300")])
def test_a_speed_out_of_reach_is_named_before_sampling(speeds, name):
    """Sampling gave up after 24 rounds before, without a word on the row."""

    def known(x):
        return 50.0 + 10.0 * (x[:, 0] - x[:, 0].mean()), np.full(len(x), 1.0), np.full(len(x), 2.0)

    seen = [Observed(np.array([speed]), np.array([1.0]), f"{tilt} deg") for tilt, speed in enumerate(speeds)]
    tilt = speeds.index(float(name))
    with pytest.raises(InputError, match=rf"outlier: the row of {tilt} deg and {name} mm/s lies \d+ standard"):
        importance_sampling.sample(THREE, seen, [known] * 3, 1, silent)


def test_a_speed_that_contradicts_the_others_is_named_where_sampling_fails():
    """Rows of 0, 0 and 9 deviations from the best draw of the others; alike contradictions name none."""
    seen = [Observed(np.array([50.0, 51.0]), np.ones(2), "5 deg"), Observed(np.array([80.0]), np.ones(1), "10 deg")]
    with pytest.raises(InputError, match="the row of 10 deg and 80 mm/s lies 9 standard deviations from what"):
        importance_sampling._check_contradiction(np.array([[0.0, 0.1, 9.0], [5.0, 5.0, 1.0]]), seen)
    importance_sampling._check_contradiction(np.array([[0.5, 0.1, 2.0], [5.0, 5.0, 1.0]]), seen)
