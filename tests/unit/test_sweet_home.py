"""Reading of furniture libraries, on archives made here."""

import re

import numpy as np
import pytest

from sceneq_tools.room.category import Category
from sceneq_tools.room.models.libraries import open_library
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.models.sweet_home import SweetHomeLibrary

from support.furniture import BOX, CATALOGUE, MATERIALS, write_library

STOOL = Category("stool", "stool", "wood", ("sit",), (), ("Test#stool", "Test#no-such"))


def library(folder, **texts):
    write_library(folder, **texts)
    return SweetHomeLibrary(folder, (STOOL,))


def test_the_table_keeps_only_models_that_are_there(tmp_path):
    (category,) = library(tmp_path).categories()
    assert category.models == ("Test#stool",)


def test_a_model_has_the_size_of_the_catalogue_and_stands_on_its_origin(tmp_path):
    mesh = library(tmp_path).mesh("Test#stool")
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    np.testing.assert_allclose(low, [-0.2, -0.1, 0.0], atol=1e-6)
    np.testing.assert_allclose(high, [0.2, 0.1, 0.6], atol=1e-6)
    assert len(mesh.faces) == 12


def test_a_models_front_comes_to_look_along_minus_y(tmp_path):
    obj = BOX + "usemtl front\nv 0.4 1 1\nv 0.6 1 1\nv 0.5 1.2 1\nf 9 10 11\n"
    mesh = library(tmp_path, obj=obj).mesh("Test#stool")
    front = mesh.vertices[mesh.faces[-1]]
    np.testing.assert_allclose(front[:, 1], -0.1, atol=1e-6)
    np.testing.assert_allclose(mesh.normals[mesh.faces[-1]], [[0, -1, 0]] * 3, atol=1e-6)


def test_a_model_is_turned_before_it_is_scaled(tmp_path):
    turned = CATALOGUE + "modelRotation#1=0 0 1 0 1 0 -1 0 0\n"
    obj = BOX + "usemtl front\nv 0.4 1 1\nv 0.6 1 1\nv 0.5 1.2 1\nf 9 10 11\n"
    mesh = library(tmp_path, catalogue=turned, obj=obj).mesh("Test#stool")
    np.testing.assert_allclose(mesh.vertices[mesh.faces[-1]][:, 0], 0.2, atol=1e-6)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.4, 0.2, 0.6], atol=1e-6)


def test_materials_are_read_with_their_pictures(tmp_path):
    red, pictured, lost, glass = library(tmp_path).mesh("Test#stool").materials
    assert red.colour == (0.8, 0.1, 0.1)
    assert (red.shine, red.gloss) == (pytest.approx(0.2), 30.0)
    assert pictured.colour == (1.0, 1.0, 1.0), "black before a picture is no choice"
    assert pictured.texture.shape == (384, 768, 4)
    np.testing.assert_array_equal(pictured.texture[0, 0], [200, 0, 0, 255])
    assert lost.texture is None, "two pictures to choose from, neither of that name"
    assert glass.opacity == pytest.approx(0.2)


def test_a_picture_of_that_name_is_found_wherever_the_author_had_it(tmp_path):
    mtl = MATERIALS.replace("gone.png", "OTHER.png")
    assert library(tmp_path, mtl=mtl).mesh("Test#stool").materials[2].texture.shape == (8, 8, 4)


def test_hidden_and_empty_faces_are_dropped(tmp_path):
    mtl = MATERIALS.replace("Tr 0.8", "Tr 1")
    mesh = library(tmp_path, mtl=mtl, obj=BOX + "f 1 1 2\nf 1 2\n").mesh("Test#stool")
    assert len(mesh.faces) == 10
    assert len(mesh.materials) == 3


def test_meshes_are_cached_and_scaled(tmp_path):
    stools = library(tmp_path)
    assert stools.mesh("Test#stool") is stools.mesh("Test#stool")
    assert stools.mesh("Test#stool", 0.5).vertices[:, 2].max() == pytest.approx(0.3)


def test_attribution_names_author_and_licence(tmp_path):
    line = library(tmp_path).attribution("Test#stool")
    assert line == "Stühlchen | Ann | Test catalogue | CC0 © nobody"


def test_the_same_id_in_two_archives_stays_apart(tmp_path):
    write_library(tmp_path, "Another.sh3f")
    assert library(tmp_path).model_ids() == ("Test#stool", "Test.sh3f:Test#stool")


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ({"obj": BOX + "v 1 two 3\n"}, "Test.sh3f: test/stool/stool.obj: line 24: .*'1 two 3'"),
        ({"obj": BOX + "f 1 2 77\n"}, "stool.obj: line 24: corner 77 points outside 8 positions"),
        ({"obj": BOX + "f 1 2 x\n"}, "stool.obj: line 24: 'x' is no corner"),
        ({"mtl": "newmtl red\nKd 1 0\n"}, "Test.sh3f: test/stool/stool.mtl: line 2: .*Kd 1 0"),
        ({"obj": "v 0 0 0\n"}, "stool.obj: no visible triangle"),
    ],
)
def test_a_broken_model_is_named_with_its_line(tmp_path, texts, message):
    stools = library(tmp_path, **texts)
    with pytest.raises(ValueError, match=message):
        stools.mesh("Test#stool")


@pytest.mark.parametrize(
    ("catalogue", "message"),
    [
        (CATALOGUE.replace("width#1=40", "width#1=wide"), "width#1 should be 1 number"),
        (CATALOGUE.replace("width#1=40\n", ""), "entry 1 has no width#1"),
        (CATALOGUE.replace("=40", "=-4"), "width#1 must be greater than zero"),
        (CATALOGUE + "modelRotation#1=1 0\n", "modelRotation#1 should be 9 number"),
    ],
)
def test_a_broken_catalogue_is_named_with_its_key(tmp_path, catalogue, message):
    with pytest.raises(ValueError, match=re.escape("Catalog.properties: ") + message):
        library(tmp_path, catalogue=catalogue)


def test_what_is_no_archive_is_named(tmp_path):
    (tmp_path / "Bad.sh3f").write_bytes(b"not a zip")
    with pytest.raises(ValueError, match=r"Bad\.sh3f: no readable archive"):
        SweetHomeLibrary(tmp_path, (STOOL,))


def test_unknown_models_and_tints_are_named(tmp_path):
    stools = library(tmp_path)
    with pytest.raises(ValueError, match="no model 'Test#no-such' in sweethome3d-furniture"):
        stools.mesh("Test#no-such")
    with pytest.raises(ValueError, match="Test#stool: no tint 'mauve'"):
        stools.mesh("Test#stool", tint="mauve")


def test_without_the_package_there_are_shapes(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("SCENEQ_FURNITURE_DIR", str(tmp_path))
    with caplog.at_level("INFO"):
        assert isinstance(open_library(), ParametricLibrary)
    assert "apt-get install sweethome3d-furniture" in caplog.text
