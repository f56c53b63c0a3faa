"""What is quick has the bits of what is slow."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from physagent_studio.reconstruction.photo.statistics import (
    lengths,
    median,
)

FLOATS = st.floats(-1e4, 1e4, width=32)
KINDS = st.sampled_from([np.float32, np.float64])


@given(KINDS.flatmap(lambda k: arrays.arrays(k, st.integers(1, 80), elements=FLOATS)))
def test_the_median_is_that_of_numpy(values) -> None:
    ordered = np.sort(values)
    assert median(ordered) == float(np.median(values))


@given(KINDS, st.integers(2, 3), st.integers(0, 60), st.integers(0, 9))
def test_lengths_are_those_of_numpy(kind, axes: int, count: int, seed: int) -> None:
    vectors = np.random.default_rng(seed).normal(0, 40, (count, axes)).astype(kind)
    assert np.array_equal(lengths(vectors), np.linalg.norm(vectors, axis=1))
