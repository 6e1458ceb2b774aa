"""Uncertain inputs: their draws have the means and deviations that people wrote."""

import numpy as np
import pytest
from scipy.special import ndtri

from walkergen.core.scene import Contact, Scene
from walkergen.core.theory import uncertain_inputs
from walkergen.core.theory.uncertain_inputs import Input
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

DESIGN, SCENE = Design(), Scene()


def _names(reader, design=DESIGN):
    return {one.name for one in uncertain_inputs.inputs(SCENE, design, reader)}


def test_each_reader_gets_the_inputs_that_it_reads():
    of_motor = {"drive.frequency_hz", "drive.eccentric_g_mm"}
    assert _names(uncertain_inputs.SPACE_READER) - _names(uncertain_inputs.PREDICTION_READER) == {"legs.damping_ratio"}
    assert {"feet.unevenness_um", "feet.tip_radius_um"} < _names(uncertain_inputs.PREDICTION_READER)
    assert not of_motor & _names(uncertain_inputs.SPACE_READER)
    assert "leg mass" not in _names(uncertain_inputs.SPACE_READER, DESIGN.variant(kind="braced"))


def test_an_input_without_deviation_is_known():
    exact = SCENE.model_copy(update={"contact": Contact(restitution_sd=0.0)})
    names = {one.name for one in uncertain_inputs.inputs(exact, DESIGN, "space")}
    assert "contact.restitution" not in names
    assert uncertain_inputs.sample_inputs((), 4, seed=1).shape == (4, 0)


def test_draws_have_the_moments_written_and_stay_in_range():
    known = (Input("wide", 3.0, 0.3), Input("cut", 0.9, 0.2, 0.0, 1.0), Input("fold", 0.0, 5.0, folded=True))
    wide, cut, fold = uncertain_inputs.sample_inputs(known, 1024, seed=3).T
    assert wide.mean() == pytest.approx(3.0, abs=1e-3)  # points of a lattice: far below 0.3/32
    assert wide.std() == pytest.approx(0.3, rel=0.01)
    assert 0.0 <= cut.min() < cut.max() <= 1.0
    from scipy.stats import truncnorm

    law = truncnorm(-4.5, 0.5, 0.9, 0.2)
    assert cut.mean() == pytest.approx(law.mean(), abs=2e-3)
    assert fold.min() >= 0.0
    assert fold.mean() == pytest.approx(5.0 * np.sqrt(2.0 / np.pi), rel=0.01)


def test_draws_depend_on_the_seed_alone():
    known = uncertain_inputs.inputs(SCENE, DESIGN, "space")
    first = uncertain_inputs.sample_inputs(known, 16, seed=1)
    assert np.array_equal(first, uncertain_inputs.sample_inputs(known, 16, seed=1))
    assert not np.array_equal(first, uncertain_inputs.sample_inputs(known, 16, seed=2))


def test_values_reach_scene_design_and_masses():
    values = {
        "contact.friction": 0.3,
        "legs.thickness_mm": 0.44,
        "legs.damping_ratio": 0.08,
        "material.youngs_modulus_gpa": 2.5,
        "body mass": 1.1,
        "leg mass": 0.9,
        "feet.unevenness_um": 4.0,
    }
    scene, design, mass = uncertain_inputs.apply_inputs(SCENE, DESIGN, values)
    plain = solids.mass_of(DESIGN)
    assert (scene.contact.friction, scene.feet.unevenness_um) == (0.3, 4.0)
    assert scene.legs.damping_ratio == 0.08
    assert (design.legs.flexible_thickness_mm, design.material.youngs_modulus_gpa) == (0.44, 2.5)
    assert mass.M == pytest.approx(1.1 * plain.M)
    assert mass.spatial.body == pytest.approx(1.1 * plain.spatial.body)
    for leg, before in zip(mass.legs, plain.legs, strict=True):
        assert leg.m == pytest.approx(0.9 * 1.1 * before.m, rel=2e-3)  # 1.1: of the thickness


def test_without_changes_the_design_is_returned():
    scene, design, mass = uncertain_inputs.apply_inputs(SCENE, DESIGN, {})
    assert (scene, design) == (SCENE, DESIGN)
    assert mass.M == solids.mass_of(DESIGN).M


def test_shares_of_a_product_are_those_of_the_closed_form():
    """f = a + 2 b + a c with unit normals: variances 1, 4 and 1 (of the product), 6 in all."""
    known = tuple(Input(name, 0.0, 1.0, -np.inf) for name in "abc")
    found = {
        one.name: one
        for one in uncertain_inputs.variance_shares(
            known, lambda x: x[:, 0] + 2.0 * x[:, 1] + x[:, 0] * x[:, 2], seed=4
        )
    }
    expected = {"a": (1 / 6, 2 / 6), "b": (4 / 6, 4 / 6), "c": (0.0, 1 / 6)}
    for name, (first, total) in expected.items():
        (alone, alone_se), (whole, whole_se) = found[name].first.pair, found[name].total.pair
        # Four standard errors: with six numbers a false alarm in 2000 seeds; errors are below 2 %.
        assert max(alone_se, whole_se) < 0.02
        assert alone == pytest.approx(first, abs=4.0 * alone_se + 1e-3)
        assert whole == pytest.approx(total, abs=4.0 * whole_se + 1e-3)
    assert next(iter(found)) == "b"


def test_even_points_are_even_in_every_dimension_and_give_better_quantiles_than_random_ones():
    cube = uncertain_inputs.lattice_points(9, 512, 3)
    for column in cube.T:
        assert np.array_equal(np.sort((column * 512).astype(int)), np.arange(512))
    even, random = [], []
    for seed in range(40):
        for points, errors in (
            (uncertain_inputs.lattice_points(9, 512, seed), even),
            (np.random.default_rng(seed).random((512, 9)), random),
        ):
            speeds = np.exp(0.5 * points[:, :3].sum(axis=1)) + points[:, 3:].prod(axis=1)
            errors.append(np.quantile(speeds, uncertain_inputs.QUANTILES))
    assert np.all(np.std(even, axis=0) < 0.6 * np.std(random, axis=0))


def test_members_of_a_family_share_read_only_draws():
    known = (Input("contact.friction", 0.25, 0.02),)
    first, again = uncertain_inputs.sample_inputs(known, 64, 1), uncertain_inputs.sample_inputs(list(known), 64, 1)
    assert first is again
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0.0


def test_quantiles_of_a_normal_input_are_those_of_scipy():
    shares = np.r_[1e-300, 1e-12, np.linspace(0.001, 0.999, 999), 1.0 - 1e-15]
    standard = Input("x", 0.0, 1.0, -np.inf)
    assert uncertain_inputs.input_quantiles(standard, shares) == pytest.approx(ndtri(shares), rel=1e-13, abs=1e-15)


def test_a_leg_is_drawn_as_thick_as_a_design_may_have():
    _, design, _ = uncertain_inputs.apply_inputs(SCENE, DESIGN, {"legs.thickness_mm": 7.9e-7})
    assert design.legs.flexible_thickness_mm == 1e-6
