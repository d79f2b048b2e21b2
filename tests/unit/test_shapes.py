"""The parametric library."""

import numpy as np
import pytest

from sceneq_tools.room.models.curated import ROLES
from sceneq_tools.room.models.shapes import ParametricLibrary

LIBRARY = ParametricLibrary()
MODELS = [(c, model) for c in LIBRARY.categories() for model in c.models]


def test_there_is_a_shape_for_every_role():
    assert {category.role for category in LIBRARY.categories()} == set(ROLES)
    assert len(LIBRARY.categories()) >= 25


@pytest.mark.parametrize(("category", "model"), MODELS, ids=[model for _, model in MODELS])
def test_every_shape_stands_centred_on_its_origin(category, model):
    mesh = LIBRARY.mesh(model)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    np.testing.assert_allclose([*(low + high)[:2], low[2]], 0.0, atol=1e-5)
    assert np.all(high - low < 2.5), "in metres"
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all((across * mesh.normals[mesh.faces].mean(axis=1)).sum(axis=1) >= -1e-9)
    for tint in category.tints:
        assert LIBRARY.mesh(model, tint=tint).materials != mesh.materials


def test_the_front_of_a_sofa_is_open_towards_minus_y():
    mesh = LIBRARY.mesh("shapes#sofa")
    high = mesh.vertices[mesh.vertices[:, 2] > 0.7]
    assert high[:, 1].min() > 0


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="no model 'shapes#spoon' in shapes"):
        LIBRARY.mesh("shapes#spoon")
    with pytest.raises(ValueError, match="shapes#sofa: no tint 'mauve'"):
        LIBRARY.mesh("shapes#sofa", tint="mauve")
    assert LIBRARY.attribution("shapes#sofa") == ""
