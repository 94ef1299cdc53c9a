"""The mid-surface: the same as the command's, arrays without copies, and what is said of bad input."""

from __future__ import annotations

import json
import pickle
import subprocess
from pathlib import Path
from typing import Any

import midsurf
import numpy as np
import pytest

Arrays = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]


def plate(thickness: float = 1.0) -> Arrays:
    """A box of 10 by 6, so thick."""
    x, y, z = 10.0, 6.0, thickness
    vertices = np.array([(i * x, j * y, k * z) for k in (0, 1) for j in (0, 1) for i in (0, 1)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


@pytest.fixture
def tee(fixtures: Path) -> midsurf.MidSurface:
    return midsurf.extract(fixtures / "tee.obj", coping=fixtures / "tee.coping.txt", cell="1t")


def test_a_plate_has_its_middle_and_its_thickness() -> None:
    flags = np.zeros(12, dtype=bool)
    flags[4:] = True
    mid = midsurf.extract(plate(0.8), coping=flags, cell=0.5)
    assert mid.sheet_count == 1 and not mid.seams and not len(mid.cracks)
    assert np.abs(mid.vertices[:, 2] - 0.4).max() < 1e-9
    assert np.abs(mid.thickness - 0.8).max() < 1e-9
    assert mid.report["area"] == pytest.approx(60.0, rel=1e-9)
    assert {border.kind for border in mid.borders} == {"coping"}
    # Each footpoint is straight above or below its vertex.
    feet = np.sort(mid.footpoints[:, :, 2], axis=1)
    assert np.abs(feet - [0.0, 0.8]).max() < 1e-9
    assert np.abs(mid.footpoints[:, :, :2] - mid.vertices[:, None, :2]).max() < 1e-9


@pytest.mark.parametrize("suffix", [".ply", ".vtu", ".obj", ".stl", ".inp", ".msh"])
def test_files_are_those_of_the_command(command: str, fixtures: Path, tmp_path: Path, suffix: str) -> None:
    part, tags = fixtures / "tee.obj", fixtures / "tee.coping.txt"
    theirs, ours = tmp_path / f"theirs{suffix}", tmp_path / f"ours{suffix}"
    run = [command, "extract", part, "--coping", tags, "--cell", "1t", "-q", "-o", theirs]
    subprocess.run([str(word) for word in run], check=True)
    midsurf.extract(part, coping=tags, cell="1t", threads=1).save(ours)
    assert ours.read_bytes() == theirs.read_bytes()


def test_arrays_look_at_the_surface_and_outlive_it(tee: midsurf.MidSurface) -> None:
    for array in (tee.vertices, tee.thickness, tee.triangles, tee.sheet):
        assert not array.flags.owndata and not array.flags.writeable
        with pytest.raises(ValueError):
            array.flags.writeable = True
    assert np.shares_memory(tee.vertices, tee.vertices)
    vertices, count = tee.vertices, len(tee.vertices)
    before = vertices.copy()
    del tee
    assert vertices.shape == (count, 3)
    assert (vertices == before).all()


def test_seams_and_borders_run_along_edges(tee: midsurf.MidSurface) -> None:
    edges = {frozenset(pair) for t in tee.triangles.tolist() for pair in zip(t, t[1:] + t[:1])}
    assert len(tee.seams) == 1 and len(tee.seams[0].sheets) == 3
    paths = [line.path.tolist() for line in tee.seams] + [line.path.tolist() for line in tee.borders]
    for path in paths:
        for pair in zip(path, path[1:]):
            assert frozenset(pair) in edges
    points, starts = tee.all_footpoints
    on_seam = tee.seams[0].path[1]
    assert starts[on_seam + 1] - starts[on_seam] == 3
    away = np.linalg.norm(points[starts[on_seam] : starts[on_seam + 1]] - tee.vertices[on_seam], axis=1)
    assert away == pytest.approx(tee.radius[on_seam], rel=1e-6)


def test_any_number_of_threads_gives_the_same(fixtures: Path) -> None:
    one, three = (midsurf.extract(fixtures / "bracket.obj", threads=n) for n in (1, 3))
    assert (one.vertices == three.vertices).all() and (one.triangles == three.triangles).all()


def test_the_tags_found_are_those_of_auto(fixtures: Path, tmp_path: Path) -> None:
    part = fixtures / "bracket.obj"
    tags = midsurf.detect_coping(part)
    assert tags.flags.any() and not tags.flags.all()
    tags.save(tmp_path / "tags.toml")
    by_file = midsurf.extract(part, coping=tmp_path / "tags.toml", cell="1t")
    by_word = midsurf.extract(part, cell="1t")
    assert (by_file.vertices == by_word.vertices).all()
    assert tags.report["faces"]


def test_a_pickled_surface_is_the_same(tee: midsurf.MidSurface, tmp_path: Path) -> None:
    copy = pickle.loads(pickle.dumps(tee))
    for name in ("vertices", "triangles", "thickness", "radius", "sheet", "kind", "footpoints", "junctions"):
        assert np.array_equal(getattr(copy, name), getattr(tee, name)), name
    assert copy.report["counts"] == tee.report["counts"]
    tee.save(tmp_path / "a.ply")
    copy.save(tmp_path / "b.ply")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    with pytest.raises(midsurf.InputError, match="came without one"):
        copy.save(tmp_path / "c.inp")


def test_a_saved_surface_is_read_back(tee: midsurf.MidSurface, tmp_path: Path) -> None:
    tee.save(tmp_path / "mid.ply")
    back = midsurf.MidSurface.read(tmp_path / "mid.ply")
    assert np.array_equal(np.sort(back.radius), np.sort(tee.radius))
    assert back.sheet_count == tee.sheet_count and len(back.triangles) == len(tee.triangles)
    assert len(back.seams) == len(tee.seams)
    assert np.isnan(back.footpoints).all()


def test_other_libraries_get_the_data(tee: midsurf.MidSurface) -> None:
    mesh = tee.to_meshio()
    assert (mesh.points == tee.vertices).all() and (mesh.cells_dict["triangle"] == tee.triangles).all()
    assert (mesh.point_data["thickness"] == tee.thickness).all()
    pyvista = pytest.importorskip("pyvista")
    poly = tee.to_pyvista()
    assert isinstance(poly, pyvista.PolyData) and poly.n_cells == len(tee.triangles)
    assert (poly.cell_data["sheet"] == tee.sheet).all()


def test_elements_are_as_long_as_asked_for(fixtures: Path) -> None:
    mid = midsurf.extract(
        fixtures / "tee.obj", coping=fixtures / "tee.coping.txt", element_size="1t", quads=True, junctions="straight"
    )
    a, b, _ = (mid.vertices[mid.triangles[:, corner]] for corner in range(3))
    length = np.median(mid.thickness)
    assert 0.5 < np.median(np.linalg.norm(a - b, axis=1)) / length < 1.5
    assert len(mid.quads)


def test_info_says_what_the_command_says(command: str, fixtures: Path) -> None:
    part = fixtures / "bracket.obj"
    told = subprocess.run([command, "info", str(part), "--json"], check=True, stdout=subprocess.PIPE).stdout
    assert midsurf.info(part) == json.loads(told)
    assert midsurf.info(plate(), coping="none", min_wall=2.0)["thickness"]["check"]["passed"] is False


def test_errors_are_those_of_the_command(command: str, fixtures: Path, tmp_path: Path) -> None:
    gap = tmp_path / "gap.obj"
    lines = (fixtures / "plate.obj").read_text().splitlines()
    faces = [number for number, line in enumerate(lines) if line.startswith("f ")]
    gap.write_text("\n".join(line for number, line in enumerate(lines) if number != faces[-1]))
    for part, code in ((gap, 2), (tmp_path / "none.stl", 2), (FOLDER, 2)):
        done = subprocess.run([command, "extract", str(part)], stderr=subprocess.PIPE, text=True)
        assert done.returncode == code
        with pytest.raises(midsurf.InputError) as raised:
            midsurf.extract(part)
        theirs = " ".join(done.stderr.replace("×", " ").replace("│", " ").split())
        assert " ".join(raised.value.message.split()) in theirs
        assert raised.value.help and str(raised.value).endswith(raised.value.help)
    with pytest.raises(midsurf.InputError) as raised:
        midsurf.extract(gap)
    # Flags are spelt as arguments, and those of other functions are left out.
    assert "allow_open" in str(raised.value.help) and "--" not in str(raised.value.help)
    with pytest.raises(midsurf.InputError) as raised:
        midsurf.offset(gap, 1.0)
    assert "allow_open" not in str(raised.value.help)


FOLDER = Path(__file__).parent


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"cell": -1.0}, "cell"),
        ({"cell": "1mm"}, "cell"),
        ({"cell": float("nan")}, "cell"),
        ({"angle": 180.0}, "angle"),
        ({"weld": float("inf")}, "weld"),
        ({"threads": 0}, "threads"),
        ({"memory_limit": "lots"}, "memory_limit"),
        ({"memory_limit": 1}, "memory"),
        ({"quads": True}, "element_size"),
        ({"element_size": 1.0, "grading": -1.0}, "grading"),
        ({"coping": [True]}, "coping flags"),
        ({"coping": [1.5]}, "coping"),
        ({"coping": [True] * 12}, "coping"),
        ({"junctions": "round"}, "junctions"),
    ],
)
def test_bad_arguments_are_refused_in_words(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(midsurf.InputError) as raised:
        midsurf.extract(plate(), **arguments)
    assert words in str(raised.value)


@pytest.mark.parametrize(
    "part",
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int)),
        (np.zeros((3, 2)), [[0, 1, 2]]),
        (np.eye(3), [[0, 1, 9]]),
        (np.eye(3), [[0, 1, -1]]),
        (np.eye(3), [[0.5, 1.0, 2.0]]),
        (np.full((3, 3), np.nan), [[0, 1, 2]]),
        ([["a", "b", "c"]], [[0, 0, 0]]),
        7,
    ],
)
@pytest.mark.parametrize("verb", [midsurf.extract, midsurf.info, midsurf.detect_coping, midsurf.roundtrip])
def test_bad_arrays_are_refused_in_words(part: Any, verb: Any) -> None:
    with pytest.raises(midsurf.InputError):
        verb(part)
