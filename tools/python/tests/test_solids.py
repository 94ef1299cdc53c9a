"""Solids: offset, hollow, thicken, rethicken, roundtrip, subdivide."""

from __future__ import annotations

import subprocess
from pathlib import Path

import midsurf
import numpy as np
import pytest
from test_extract import plate


def test_an_offset_has_its_volume_and_owns_its_arrays() -> None:
    grown = midsurf.offset(plate(), 1.0, cell=0.25)
    # Minkowski: volume, area times r, edges times pi r^2 / 4, a ball.
    x, y, z = 10.0, 6.0, 1.0
    volume = x * y * z + 2 * (x * y + y * z + z * x) + np.pi * (x + y + z) + 4 * np.pi / 3
    assert grown.volume == pytest.approx(volume, rel=2e-3)
    assert grown.vertices.flags.writeable and grown.vertices.flags.c_contiguous
    assert grown.report["pieces"] == 1
    shrunk = midsurf.offset(grown, -1.0, cell=0.25)
    assert shrunk.volume == pytest.approx(60.0, rel=1e-2)
    with pytest.raises(midsurf.NoResultError, match="nothing is left"):
        midsurf.offset(plate(), -0.6, cell=0.25)
    with pytest.raises(midsurf.InputError, match="distance"):
        midsurf.offset(plate(), 0.0)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".obj"])
def test_files_are_those_of_the_command(command: str, fixtures: Path, tmp_path: Path, suffix: str) -> None:
    part, theirs, ours = fixtures / "tee.obj", tmp_path / f"theirs{suffix}", tmp_path / f"ours{suffix}"
    run = [command, "offset", str(part), "--distance", "1", "--cell", "2%", "-q", "-o", str(theirs)]
    subprocess.run(run, check=True)
    midsurf.offset(part, 1.0, cell="2%", single_precision=suffix == ".stl").save(ours)
    assert ours.read_bytes() == theirs.read_bytes()


def test_hollow_keeps_the_outside() -> None:
    vertices, triangles = plate(6.0)
    hollow = midsurf.hollow((vertices, triangles), 1.0, cell=0.25)
    assert (hollow.vertices[:8] == vertices).all() and (hollow.triangles[:12] == triangles).all()
    assert hollow.volume == pytest.approx(360.0 - 8.0 * 4.0 * 4.0, rel=1e-3)
    assert len(hollow.report["cavities"]) == 1
    drained = midsurf.hollow((vertices, triangles), 1.0, cell=0.25, drain=["1@5,3,6"])
    assert drained.report["cavities"] == []
    with pytest.raises(midsurf.InputError, match="drain"):
        midsurf.hollow((vertices, triangles), 1.0, drain=["nowhere"])


def test_thicken_is_one_sided() -> None:
    vertices = [(0, 0, 0), (8, 0, 0), (8, 4, 0), (0, 4, 0)]
    solid = midsurf.thicken((vertices, [(0, 1, 2), (0, 2, 3)]), 1.0, side="outer")
    assert solid.volume == pytest.approx(32.0, rel=1e-6)
    assert solid.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(midsurf.InputError, match="too large for a thickness"):
        midsurf.thicken((vertices, [(0, 1, 2), (0, 2, 3)]), 1.0, cell=0.6)


def test_rethicken_takes_all_it_says(fixtures: Path, tmp_path: Path) -> None:
    part = fixtures / "plate.obj"
    mid = midsurf.extract(part, coping=fixtures / "plate.coping.txt", cell="1t")
    volume = midsurf.info(part)["volume"]
    assert midsurf.rethicken(mid).volume == pytest.approx(volume, rel=1e-3)
    mid.save(tmp_path / "mid.ply")
    again = midsurf.rethicken(tmp_path / "mid.ply")
    assert again.volume == pytest.approx(volume, rel=1e-3)
    twice = midsurf.rethicken((mid.vertices, mid.triangles), thickness=2.0 * float(mid.thickness[0]))
    assert twice.volume == pytest.approx(2.0 * volume, rel=1e-3)
    (tmp_path / "shell.obj").write_text("g rib\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n")
    rib = midsurf.rethicken(tmp_path / "shell.obj", thickness=1.0, groups={"rib": 2.0})
    assert rib.volume == pytest.approx(32.0, rel=1e-3)
    with pytest.raises(midsurf.InputError, match="no group named ribs"):
        midsurf.rethicken(tmp_path / "shell.obj", thickness=1.0, groups={"ribs": 2.0})
    with pytest.raises(midsurf.InputError, match="no thickness of their own"):
        midsurf.rethicken((mid.vertices, mid.triangles))


def test_a_plate_comes_back_from_the_round_trip(fixtures: Path) -> None:
    there = midsurf.roundtrip(fixtures / "plate.obj", coping=fixtures / "plate.coping.txt", cell="1t")
    assert there.comparison["volume_ratio"] == pytest.approx(1.0, abs=1e-3)
    assert there.comparison["closed"] and there.solid.volume > 0 and there.mid.sheet_count == 1


def test_subdivide_makes_a_wall() -> None:
    vertices, _ = plate(10.0)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    wall = midsurf.subdivide((vertices, quads), 0.2, samples=4, levels=1)
    assert wall.thickness is not None and len(wall.thickness) == len(wall.vertices)
    assert wall.thickness.max() == pytest.approx(0.2, rel=1e-6)
    assert 0.0 < wall.volume < 0.2 * midsurf.info(plate(10.0), coping="none")["area"]
    turned = midsurf.subdivide((vertices, [face[::-1] for face in quads]), 0.2, samples=4)
    assert [warning.code for warning in turned.warnings] == ["inside_out"]
    with pytest.raises(midsurf.InputError, match="thickness"):
        midsurf.subdivide((vertices, quads), -1.0)
    with pytest.raises(midsurf.InputError, match="scheme"):
        midsurf.subdivide((vertices, quads), 0.2, scheme="magic")


def test_meshes_of_other_libraries_are_parts() -> None:
    class Trimesh:
        vertices, faces = plate()

    assert midsurf.info(Trimesh(), coping="none")["volume"] == pytest.approx(60.0)
    assert midsurf.info(midsurf.Mesh(*plate()), coping="none")["volume"] == pytest.approx(60.0)
