"""Many parts on a cluster: the same bytes as one machine, killed workers, runs that go on."""

from __future__ import annotations

import csv
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import midsurf
import midsurf.dask
import pytest
from distributed import Client, LocalCluster

PARTS = ("box_divider", "cross", "ell", "ell_bend", "ibeam", "open_box", "plate", "plate_holes", "tee", "tee_filleted")


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


@pytest.fixture
def parts(fixtures: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "parts"
    folder.mkdir()
    for name in PARTS:
        for suffix in (".obj", ".coping.txt"):
            (folder / f"{name}{suffix}").write_bytes((fixtures / f"{name}{suffix}").read_bytes())
    return folder


def test_many_parts_are_those_of_one_machine(client: Client, parts: Path, tmp_path: Path) -> None:
    (parts / "broken.stl").write_text("solid nothing\nendsolid\n")
    out, told = tmp_path / "mids", []
    table = midsurf.dask.extract_many(
        parts, client, out=out, suffix=".ply", cell="1t", progress=lambda done, of, row: told.append((done, of))
    )
    assert [row.part for row in table] == sorted(["broken.stl", *(f"{name}.obj" for name in PARTS)])
    assert told == [(n + 1, 11) for n in range(11)]
    by_name = {row.part: row for row in table}
    assert by_name["broken.stl"].status == "refused" and "broken.stl" in by_name["broken.stl"].message
    assert [row.part for row in table.failed()] == ["broken.stl"]
    for name in PARTS:
        alone = midsurf.extract(parts / f"{name}.obj", coping=parts / f"{name}.coping.txt", cell="1t")
        alone.save(tmp_path / "alone.ply")
        assert (out / f"{name}.ply").read_bytes() == (tmp_path / "alone.ply").read_bytes()
        assert by_name[f"{name}.obj"].triangles == len(alone.triangles)
    with open(out / midsurf.dask.TABLE, newline="", encoding="utf-8") as file:
        assert [row["part"] for row in csv.DictReader(file)] == [row.part for row in table]


def test_what_is_done_is_not_done_again(client: Client, parts: Path, tmp_path: Path) -> None:
    out = tmp_path / "mids"
    first = midsurf.dask.extract_many(parts, client, out=out, cell="1t", progress=False)
    stamps = {file: file.stat().st_mtime_ns for file in out.glob("*.vtu")}
    (out / "tee.vtu").unlink()
    (parts / "plate.obj").write_bytes((parts / "plate.obj").read_bytes() + b"# touched\n")
    again = midsurf.dask.extract_many(parts, client, out=out, cell="1t", progress=False)
    assert [row[:10] for row in again if row.part not in ("plate.obj", "tee.obj")] == [
        row[:10] for row in first if row.part not in ("plate.obj", "tee.obj")
    ]
    changed = {file.name for file in out.glob("*.vtu") if stamps[file] != file.stat().st_mtime_ns}
    assert changed == {"tee.vtu", "plate.vtu"}
    finer = midsurf.dask.extract_many(parts, client, out=out, cell="0.8t", progress=False)
    assert all(row.cell < other.cell for row, other in zip(finer, first))


def kill_one_at_work(client: Client, killed: list[int], begun: Callable[[], bool] = lambda: True) -> None:
    """Kills a worker that has something in hand, once something else has begun to be there."""
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not killed:
        for address, keys in client.processing().items():
            info = client.scheduler_info(n_workers=-1)["workers"].get(address)
            if keys and info and begun():
                pid = client.run(os.getpid, workers=[address])[address]
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
                return
        time.sleep(0.01)


def test_a_killed_worker_takes_no_part_with_it(client: Client, parts: Path, tmp_path: Path) -> None:
    out = tmp_path / "mids"
    killed: list[int] = []
    killer = threading.Thread(target=kill_one_at_work, args=(client, killed, lambda: any(out.glob("*.vtu"))))
    killer.start()
    table = midsurf.dask.extract_many(parts, client, out=out, cell="0.5t", progress=False)
    killer.join()
    assert killed, "all parts were done before a worker could be killed"
    assert {row.status for row in table} == {"done"} and len(table) == len(PARTS)
    alone = midsurf.extract(parts / "tee.obj", coping=parts / "tee.coping.txt", cell="0.5t")
    alone.save(tmp_path / "alone.vtu")
    assert (out / "tee.vtu").read_bytes() == (tmp_path / "alone.vtu").read_bytes()


def test_one_part_in_pieces_is_that_of_one_machine(client: Client, parts: Path, tmp_path: Path) -> None:
    file, coping = parts / "tee.obj", parts / "tee.coping.txt"
    told: list[tuple[str, int, int]] = []
    mid = midsurf.dask.extract(
        file, client, shards=3, coping=coping, cell="0.5t", progress=lambda stage, done, of: told.append((stage, done, of))
    )
    alone = midsurf.extract(file, coping=coping, cell="0.5t")
    for suffix in (".ply", ".vtu"):
        mid.save(tmp_path / f"pieces{suffix}")
        alone.save(tmp_path / f"alone{suffix}")
        assert (tmp_path / f"pieces{suffix}").read_bytes() == (tmp_path / f"alone{suffix}").read_bytes()
    assert mid.cell == alone.cell
    assert [step for step in told if step[0] == "shards"] == [("shards", n, 3) for n in (1, 2, 3)]
    with pytest.raises(midsurf.InputError, match="cell"):
        midsurf.dask.extract(file, client, shards=2, cell="many")
    with pytest.raises(midsurf.InputError, match="no shard 3 of 2"):
        midsurf.shard(file, (3, 2))
    piece = midsurf.shard(file, (1, 2), coping=coping, cell="2t")
    with pytest.raises(midsurf.InputError, match="shard 2/2 is missing"):
        midsurf.merge([piece])


def test_a_killed_worker_takes_no_piece_with_it(client: Client, parts: Path, tmp_path: Path) -> None:
    file, coping = parts / "box_divider.obj", parts / "box_divider.coping.txt"
    killed: list[int] = []

    def kill(stage: str, done: int, of: int) -> None:
        if stage == "shards" and done < of:
            kill_one_at_work(client, killed)

    mid = midsurf.dask.extract(file, client, shards=6, coping=coping, cell="0.4t", progress=kill)
    assert killed
    alone = midsurf.extract(file, coping=coping, cell="0.4t")
    mid.save(tmp_path / "pieces.ply")
    alone.save(tmp_path / "alone.ply")
    assert (tmp_path / "pieces.ply").read_bytes() == (tmp_path / "alone.ply").read_bytes()


def test_folders_without_parts_are_refused(client: Client, tmp_path: Path) -> None:
    with pytest.raises(midsurf.InputError, match="holds no parts"):
        midsurf.dask.extract_many(tmp_path, client, out=tmp_path / "out")
    with pytest.raises(midsurf.InputError, match="not a folder"):
        midsurf.dask.extract_many(tmp_path / "none", client, out=tmp_path / "out")
    part = tmp_path / "plate.ply"
    part.write_bytes(b"ply")
    with pytest.raises(midsurf.InputError, match="overwrite a part"):
        midsurf.dask.extract_many([part], client, out=tmp_path, suffix=".ply")
