"""Graph segments against the same merge rule written out region by region."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.segmentation.graph_segments import LEVELS, graph_segments

SCALE, MIN_PIXELS = 40.0, 4


def patchy(seed, shape=(24, 30)):
    """Return noisy patches of colour and a domain of two parts, with holes that are outside."""
    rng = np.random.default_rng(seed)
    patches = rng.normal(0, 25, (5, 6, 3)).astype(np.float32)
    colour = cv2.resize(patches, shape[::-1], interpolation=cv2.INTER_NEAREST)
    colour += rng.normal(0, 1.5, colour.shape).astype(np.float32)
    domain = np.zeros(shape, np.int32)
    domain[:, shape[1] // 2 :] = 3
    domain[rng.random(shape) < 0.1] = -1
    return cv2.GaussianBlur(colour, (0, 0), 0.8), domain


def slow_segments(colour, domain):
    """Return the frozen sets of pixels that the rule makes, with nothing but loops."""
    region = {tuple(p): frozenset([tuple(p)]) for p in np.argwhere(domain >= 0).tolist()}
    edges = sorted_edges(colour, domain)
    internal = dict.fromkeys(region.values(), 0.0)
    join(region, internal, [e for e in edges if e[0] <= LEVELS[0]])

    def similar(weight, a, b):
        return weight <= min(internal[s] + SCALE / len(s) for s in (a, b))

    for level in LEVELS[1:]:
        while merged(region, internal, [e for e in edges if e[0] <= level], similar):
            pass
    while merged(region, internal, edges, lambda _, a, b: min(len(a), len(b)) < MIN_PIXELS):
        pass
    return set(region.values())


def sorted_edges(colour, domain):
    """Return (weight in whole 256ths, number, pixel, pixel), lightest first."""
    pairs = [((v, u), (v, u + 1)) for v, u in np.ndindex(domain[:, 1:].shape)]
    pairs += [((v, u), (v + 1, u)) for v, u in np.ndindex(domain[1:].shape)]
    pairs = [(p, q) for p, q in pairs if domain[p] == domain[q] >= 0]
    weights = [
        np.floor(256 * np.sqrt(((colour[p] - colour[q]) ** 2).sum())) / 256 for p, q in pairs
    ]
    return sorted((w, i, *pair) for i, (w, pair) in enumerate(zip(weights, pairs, strict=True)))


def merged(region, internal, edges, predicate):
    """Join every region over its lightest edge if the predicate holds; tell whether any did."""
    lightest = {}
    for edge in edges:
        _, _, p, q = edge
        if region[p] != region[q]:
            lightest.setdefault(region[p], edge)
            lightest.setdefault(region[q], edge)
    good = [e for e in lightest.values() if predicate(e[0], region[e[2]], region[e[3]])]
    join(region, internal, good)
    return bool(good)


def join(region, internal, edges):
    for weight, _, p, q in edges:
        union = region[p] | region[q]
        internal[union] = max(internal[region[p]], internal[region[q]], weight)
        region.update(dict.fromkeys(union, union))


@pytest.mark.parametrize("seed", range(6))
def test_segments_are_those_of_the_rule_written_out(seed):
    colour, domain = patchy(seed)
    regions = graph_segments(colour, domain, SCALE, MIN_PIXELS)
    found = {
        frozenset(map(tuple, np.argwhere(regions == i).tolist()))
        for i in range(1, regions.max() + 1)
    }
    assert len(found) > 6
    assert found == slow_segments(colour, domain)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 30), st.integers(1, 30), st.integers(1, 40))
def test_regions_are_connected_large_enough_and_of_one_domain(seed, height, width, min_pixels):
    colour, domain = patchy(seed, (height, width))
    regions = graph_segments(colour, domain, SCALE, min_pixels)
    assert np.array_equal(regions > 0, domain >= 0)
    for region in range(1, regions.max() + 1):
        where = regions == region
        assert len(np.unique(domain[where])) == 1
        assert cv2.connectedComponents(where.astype(np.uint8), connectivity=4)[0] == 2
        alike = (domain == domain[where][0]).astype(np.uint8)
        whole = cv2.connectedComponents(alike, connectivity=4)[1]
        assert where.sum() >= min(min_pixels, (whole == whole[where][0]).sum())


def test_the_number_of_threads_changes_nothing():
    colour, domain = patchy(1, (240, 320))
    threads = cv2.getNumThreads()
    found = []
    try:
        for count in (1, 4):
            cv2.setNumThreads(count)
            found.append(graph_segments(colour, domain, SCALE, MIN_PIXELS))
    finally:
        cv2.setNumThreads(threads)
    assert np.array_equal(*found)
