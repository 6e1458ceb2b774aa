"""Statistics of crowds beside freud's (https://freud.readthedocs.io), which others wrote."""

import freud
import numpy as np
import pytest
from crowd_films import make_film

from walkergen.core import dish as dishes
from walkergen.guests.crowd.statistics import clusters, dish_geometry, order, pairs

SIDE = 100.0


def crowd(frames, walkers=300, seed=1):
    """Walkers of a periodic square that keep off each other and lean to one line."""
    dish = dishes.parse_dish(f"periodic:{SIDE:g}")
    rng, places = np.random.default_rng(seed), np.empty((frames, walkers, 3))
    for frame in range(frames):
        kept = rng.uniform(0.0, SIDE, (8 * walkers, 2))
        for _ in range(4):  # of two nearer than 3 mm the second goes
            near, _ = dish_geometry.pairs_within(*(kept - 0.5 * SIDE).T, 3.0, dish)
            kept = np.delete(kept, np.unique(near[:, 1]), axis=0)
        places[frame, :, :2] = kept[:walkers] - 0.5 * SIDE
        places[frame, :, 2] = 0.4 * rng.normal(size=walkers) + np.pi * rng.integers(0, 2, walkers)
    return make_film(places, dish.words)


def points(film, frame):
    """Places of a frame as freud takes them."""
    flat = np.zeros(film.x.shape[1])
    return np.column_stack([film.x[frame], film.y[frame], flat]).astype(np.float32)


@pytest.fixture(scope="module")
def film():
    return crowd(12)


def test_pair_correlation_is_freuds_in_a_periodic_square(film):
    found = pairs.measure(film, np.linspace(0.0, 40.0, 41))
    rdf = freud.density.RDF(bins=40, r_max=40.0, normalization_mode="finite_size")
    for frame in range(len(film.times)):
        rdf.compute((freud.box.Box.square(SIDE), points(film, frame)), reset=False)
    assert found.at == pytest.approx(rdf.bin_centers, rel=1e-5)
    assert found.g == pytest.approx(rdf.rdf, abs=2e-3)
    assert found.g[:3] == pytest.approx(0.0)
    assert found.g[3:6].max() > 1.1


@pytest.mark.parametrize("reach", [3.5, 4.5])
def test_clusters_are_freuds_by_distance(film, reach):
    round_ = film._replace(outlines={}, radii=np.full(film.x.shape[1], 0.5 * reach))
    found = clusters.measure(round_)
    for frame in range(len(film.times)):
        rival = freud.cluster.Cluster()
        box = freud.box.Box.square(SIDE)
        rival.compute((box, points(film, frame)), neighbors={"r_max": reach})
        sizes = np.array([len(keys) for keys in rival.cluster_keys])
        assert found.number[frame] == rival.num_clusters
        assert found.largest[frame] == pytest.approx(sizes.max() / sizes.sum())
        assert found.size[frame] == pytest.approx((sizes**2).sum() / sizes.sum())
    assert 1.0 < found.number.mean() < 300.0


def test_nematic_order_is_freuds_brought_from_space_to_a_plane(film):
    found = order.nematic_order(film)
    for frame, theta in enumerate(film.theta):
        rival = freud.order.Nematic()
        rival.compute(np.column_stack([np.cos(theta), np.sin(theta), 0.0 * theta]))
        # The largest eigenvalue of Q = (3 <u u> - 1) / 2 for u in a plane is (1 + 3 S) / 4
        assert found[frame] == pytest.approx((4.0 * rival.order - 1.0) / 3.0, abs=1e-5)
    assert 0.5 < found.mean() < 0.95
