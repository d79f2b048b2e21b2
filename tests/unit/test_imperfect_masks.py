import numpy as np
import pytest

from sceneq_tools.room.truth.masks import MaskParams, imperfect_masks

PERFECT = MaskParams(miss=0, split=0, merge=0, shift_px=0, least_share=0)


def tiles(count: int = 6, size: int = 40) -> np.ndarray:
    ids = np.arange(1, count * count + 1, dtype=np.uint16).reshape(count, count)
    return np.kron(ids, np.ones((size, size), np.uint16))


def pieces_of(image: np.ndarray, mask: np.ndarray) -> dict[int, set[int]]:
    return {int(i): set(np.unique(mask[image == i]).tolist()) - {0} for i in np.unique(image)}


def test_without_faults_the_masks_are_the_things_under_other_numbers() -> None:
    image = tiles()
    mask = imperfect_masks(image, np.random.default_rng(0), PERFECT)
    found = pieces_of(image, mask)
    assert all(len(numbers) == 1 for numbers in found.values())
    assert len({n for numbers in found.values() for n in numbers}) == 36
    assert not (mask == image).all()


def test_the_same_chance_gives_the_same_masks() -> None:
    one, other = (imperfect_masks(tiles(), np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_numbers_are_unrelated_from_frame_to_frame() -> None:
    image = tiles()
    first, second = (imperfect_masks(image, np.random.default_rng(k), PERFECT) for k in (1, 2))
    assert (first == second).mean() < 0.2


@pytest.mark.parametrize(
    ("fault", "low", "high"),
    [("miss", 0.05, 0.16), ("split", 0.05, 0.16), ("merge", 0.05, 0.25)],
)
def test_faults_come_as_often_as_they_should(fault: str, low: float, high: float) -> None:
    from dataclasses import replace

    params = replace(PERFECT, split_share=1e-4, again=0.0, **{fault: 0.1})
    image, counts = tiles(), []
    for seed in range(20):
        found = pieces_of(image, imperfect_masks(image, np.random.default_rng(seed), params))
        numbers = [n for segment in found.values() for n in segment]
        counts += [
            {
                "miss": not segment,
                "split": len(segment) > 1,
                "merge": any(numbers.count(n) > 1 for n in segment),
            }[fault]
            for segment in found.values()
        ]
    assert low < np.mean(counts) < high


def test_edges_are_drawn_in_and_thin_things_stay() -> None:
    image = np.zeros((120, 160), np.uint16)
    image[20:60, 20:60], image[90:92] = 1, 2
    params = MaskParams(miss=0, split=0, merge=0, shift_px=8.0, least_share=0)
    shares = [
        [(imperfect_masks(image, np.random.default_rng(s), params)[image == i] > 0).mean()
         for i in (1, 2)]
        for s in range(12)
    ]  # fmt: skip
    assert min(row[0] for row in shares) == pytest.approx(36**2 / 40**2)
    assert min(row[1] for row in shares) == 1.0


def test_specks_are_not_found_and_nothing_is_found_where_nothing_is() -> None:
    image = np.zeros((120, 160), np.uint16)
    image[5:7, 5:7] = 1
    assert not imperfect_masks(image, np.random.default_rng(0), MaskParams(miss=0)).any()


def test_impossible_parameters_are_named() -> None:
    with pytest.raises(ValueError, match="miss: must be from"):
        MaskParams(miss=1.5)
