"""Many machines, through Dask: folders of parts, retried, resumable, with a table of results; and one large part in
pieces.

>>> from distributed import Client
>>> import midsurf.dask
>>> client = Client("scheduler:8786")  # doctest: +SKIP
>>> table = midsurf.dask.extract_many("parts", client, out="mids")  # doctest: +SKIP

Clusters for Slurm, SSH and Kubernetes come with Dask (``dask-jobqueue``, ``dask-kubernetes``). Workers need the package
and the folders of parts and results, by the same paths.
"""

from __future__ import annotations

import csv
import hashlib
import json
import os
import sys
import time
import warnings as python_warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Union

from ._errors import Error, InputError
from ._arguments import Part, mesh
from ._functions import extract as _extract, merge as _merge, shard as _shard
from ._surface import MidSurface

if TYPE_CHECKING:
    from distributed import Client

#: Suffixes of files that are taken for parts in a folder.
SUFFIXES = (
    ".obj", ".stl", ".ply", ".off", ".3mf", ".glb", ".msh", ".inp", ".bdf", ".step", ".stp", ".iges", ".igs", ".brep",
)  # fmt: skip

#: The table of results, in the folder of results.
TABLE = "midsurf.csv"

#: One file of every part that is done, for the next run: its row, and what it was made of.
DONE = ".done.json"


class Row(NamedTuple):
    """What became of one part."""

    part: str
    """Its file, relative to the folder of parts."""
    status: str
    """``"done"``, ``"cracks"`` (done, but something is missing), ``"refused"`` (bad input or no result), or ``"lost"``
    (its workers died)."""
    message: str
    """Why it was refused or lost, or what was warned of."""
    sheets: int
    seams: int
    cracks: int
    triangles: int
    area: float
    thickness: float
    """Median."""
    cell: float
    seconds: float
    worker: str
    """The worker that did it."""


class Table(list[Row]):
    """Rows in the order of the parts' names."""

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the table as CSV; it appears complete or not at all."""
        target = Path(file)
        passing = target.with_name(f".{target.name}.{os.getpid()}")
        with open(passing, "w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(Row._fields)
            writer.writerows(self)
        os.replace(passing, target)

    def failed(self) -> list[Row]:
        """Rows of parts without a mid-surface."""
        return [row for row in self if row.status in ("refused", "lost")]


#: Parts: a folder, searched to the bottom, or files.
Parts = Union[str, "os.PathLike[str]", Iterable[Union[str, "os.PathLike[str]"]]]


def extract_many(
    parts: Parts,
    client: Client,
    *,
    out: str | os.PathLike[str],
    suffix: str = ".vtu",
    retries: int = 3,
    resume: bool = True,
    progress: bool | Callable[[int, int, Row], object] = True,
    **settings: Any,
) -> Table:
    """Extracts the mid-surfaces of many parts on a cluster, and returns a table of what became of each.

    Mid-surfaces are written by the workers, into ``out``, under the parts' names; each appears complete or not at all.
    A part that is refused is a row of the table and stops nothing. A worker that dies takes none with it: what it had
    is done again elsewhere, as often as Dask's ``distributed.scheduler.allowed-failures`` lets it. A run that was interrupted
    goes on where it was, as parts are known by their bytes: what is done with the same settings is not done again.

    :param parts: a folder, searched to the bottom, or files.
    :param client: a Dask client.
    :param out: folder of results; made if need be. The table is written there as ``midsurf.csv``.
    :param suffix: format of the results, as `MidSurface.save` takes it.
    :param retries: how often a part is tried again that failed by no fault of its own, as where a disk was full.
    :param resume: false does everything again.
    :param progress: a line on stderr that tells how far it is, or a function called as
        ``progress(done, of, row)`` for every row.
    :param settings: as for `midsurf.extract`, but with one thread for each part, as a worker does as many parts at
        once as it has threads; tag files named after the part (``bracket.coping.toml`` or ``.txt``
        beside ``bracket.stl``) are taken where ``coping`` is not given.
    """
    from distributed import as_completed

    files, root = _files(parts)
    target = Path(out)
    target.mkdir(parents=True, exist_ok=True)
    tell = _teller(progress)
    table: dict[str, Row] = {}
    jobs = []
    for name, (file, saved) in _names(files, root, target, suffix).items():
        job = _Job(name, str(file.absolute()), str(saved.absolute()), resume, dict(settings))
        jobs.append(job)
    futures = client.map(_one, jobs, retries=retries, pure=False)
    names = {future.key: job.name for future, job in zip(futures, jobs)}
    try:
        for future in as_completed(futures):
            name = names[future.key]
            error = future.exception()
            row = future.result() if error is None else _lost(name, error)
            table[name] = row
            tell(len(table), len(jobs), row)
            future.release()
    finally:
        client.cancel(futures)
        rows = Table(table[name] for name in sorted(table))
        rows.save(target / TABLE)
    return rows


def extract(
    part: Part,
    client: Client,
    *,
    shards: int = 16,
    retries: int = 3,
    progress: Callable[[str, int, int], object] | None = None,
    **settings: Any,
) -> MidSurface:
    """Extracts the mid-surface of one large part on a cluster, in pieces that are computed apart.

    The result is that of `midsurf.extract`, bit for bit. A worker that dies takes nothing with it but the pieces it was
    at, which are done again elsewhere. This process joins the pieces, and needs memory for the whole result.

    :param part: a file that all workers can read by the same path, or ``(vertices, triangles)``.
    :param client: a Dask client.
    :param shards: how many pieces; some times as many as there are workers keeps them all busy.
    :param retries: how often a piece is tried again that failed by no fault of its own.
    :param progress: called as ``progress("shards", done, of)``, then as for `midsurf.merge`.
    :param settings: as for `midsurf.extract`, but with one thread for each piece.
    """
    from distributed import as_completed

    joining = {name: settings.pop(name) for name in JOINING if name in settings}
    settings.setdefault("threads", 1)
    what = mesh(part)
    if isinstance(what, str):
        what = os.path.abspath(what)
    else:
        what = client.scatter(what, hash=False)
    which = [(index, shards) for index in range(1, shards + 1)]
    futures = client.map(_piece, which, part=what, settings=settings, retries=retries, pure=False)
    pieces: list[bytes] = []
    try:
        for future in as_completed(futures):
            pieces.append(future.result())
            future.release()
            if progress is not None:
                progress("shards", len(pieces), shards)
    finally:
        client.cancel(futures)
    return _merge(pieces, progress=progress, **joining)


#: Settings that the joined surface is remeshed by.
JOINING = ("element_size", "sag", "grading", "quads", "junctions")


def _piece(which: tuple[int, int], part: Part, settings: dict[str, Any]) -> bytes:
    """One shard, on a worker."""
    return _shard(part, which, **settings)


class _Job(NamedTuple):
    """One part, for a worker."""

    name: str
    part: str
    saved: str
    resume: bool
    settings: dict[str, Any]


def _one(job: _Job) -> Row:
    """Extracts one part on a worker, unless that was done before."""
    settings = _with_tags(job)
    made_of = _fingerprint(job, settings)
    note = Path(job.saved + DONE)
    if job.resume and made_of is not None:
        row = _done_before(note, made_of, job)
        if row is not None:
            return row
    start = time.monotonic()
    # A worker does as many parts at once as it has threads.
    settings.setdefault("threads", 1)
    try:
        with python_warnings.catch_warnings():
            python_warnings.simplefilter("ignore")
            mid = _extract(job.part, **settings)
            mid.save(job.saved)
    except Error as error:
        seconds = time.monotonic() - start
        return Row(job.name, "refused", str(error), 0, 0, 0, 0, 0.0, 0.0, 0.0, seconds, _worker())
    counts, thickness = mid.report["counts"], mid.report["thickness"]
    row = Row(
        part=job.name,
        status="cracks" if counts["cracks"] else "done",
        message="; ".join(warning.message for warning in mid.warnings),
        sheets=counts["sheets"],
        seams=counts["seams"],
        cracks=counts["cracks"],
        triangles=counts["triangles"],
        area=mid.report["area"],
        thickness=thickness["p50"] if thickness else 0.0,
        cell=mid.cell or 0.0,
        seconds=time.monotonic() - start,
        worker=_worker(),
    )
    # Last, so that a worker that dies before leaves nothing that looks done.
    passing = note.with_name(f".{note.name}.{os.getpid()}")
    passing.write_text(json.dumps({"made_of": made_of, "row": row._asdict()}), encoding="utf-8")
    os.replace(passing, note)
    return row


def _done_before(note: Path, made_of: str, job: _Job) -> Row | None:
    """The row of a part whose result stands."""
    try:
        told = json.loads(note.read_text(encoding="utf-8"))
        row = Row(**told["row"])
        stands = told["made_of"] == made_of and Path(job.saved).is_file() and row.part == job.name
        return row if stands else None
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _fingerprint(job: _Job, settings: Mapping[str, Any]) -> str | None:
    """What a result is made of: version, bytes of part and tags, settings; none where they cannot be read."""
    from . import __version__

    told = {name: repr(value) for name, value in sorted(settings.items()) if name not in ("threads", "memory_limit")}
    digest = hashlib.sha256(json.dumps([__version__, told]).encode())
    try:
        digest.update(Path(job.part).read_bytes())
        coping = settings.get("coping")
        if isinstance(coping, (str, os.PathLike)) and os.fspath(coping) not in ("auto", "none"):
            digest.update(Path(coping).read_bytes())
    except OSError:
        return None
    return digest.hexdigest()


def _with_tags(job: _Job) -> dict[str, Any]:
    """The settings, with the tag file beside the part."""
    settings = dict(job.settings)
    if "coping" not in settings:
        stem = Path(job.part).with_suffix("")
        beside = [Path(f"{stem}.coping{suffix}") for suffix in (".toml", ".txt")]
        found = next((file for file in beside if file.is_file()), None)
        if found is not None:
            settings["coping"] = str(found)
    return settings


def _worker() -> str:
    from distributed import get_worker

    try:
        return str(get_worker().address)
    except ValueError:
        return ""


def _lost(name: str, error: BaseException) -> Row:
    return Row(name, "lost", f"{type(error).__name__}: {error}", 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, "")


def _files(parts: Parts) -> tuple[list[Path], Path]:
    """The files, sorted, and the folder that their names are told from."""
    if isinstance(parts, (str, os.PathLike)):
        root = Path(parts)
        if not root.is_dir():
            raise InputError(f"{root}: is not a folder", "name a folder of parts, or give a list of files")
        files = [file for file in root.rglob("*") if file.suffix.lower() in SUFFIXES and file.is_file()]
    else:
        files = [Path(file) for file in parts]
        root = Path(os.path.commonpath([file.absolute().parent for file in files])) if files else Path()
    if not files:
        raise InputError(f"{root}: holds no parts", f"parts are files that end in {', '.join(SUFFIXES)}")
    return sorted(files), root


def _names(files: list[Path], root: Path, out: Path, suffix: str) -> dict[str, tuple[Path, Path]]:
    """Every part's name, file and result; two parts may differ by their suffix alone."""
    if not suffix.startswith("."):
        suffix = f".{suffix}"
    named = {file.absolute().relative_to(root.absolute()).as_posix(): file for file in files}
    stems = [Path(name).with_suffix("").as_posix() for name in named]
    results = {}
    for name, file in named.items():
        stem = Path(name).with_suffix("").as_posix()
        saved = out / (stem + suffix if stems.count(stem) == 1 else name + suffix)
        if saved.absolute() in {other.absolute() for other in files}:
            raise InputError(f"{saved}: the result would overwrite a part", "write to another folder")
        saved.parent.mkdir(parents=True, exist_ok=True)
        results[name] = (file, saved)
    return results


def _teller(progress: bool | Callable[[int, int, Row], object]) -> Callable[[int, int, Row], object]:
    if callable(progress):
        return progress
    return _bar if progress else lambda done, of, row: None


def _bar(done: int, of: int, row: Row) -> None:
    """One line on stderr, drawn over and over on a terminal, else one for every part that failed."""
    if sys.stderr.isatty():
        filled = 30 * done // of
        end = "\n" if done == of else ""
        print(f"\r[{'#' * filled}{' ' * (30 - filled)}] {done} of {of}", end=end, file=sys.stderr, flush=True)
    if row.status in ("refused", "lost"):
        lead = "\n" if sys.stderr.isatty() else ""
        print(f"{lead}{row.part}: {row.message.splitlines()[0]}", file=sys.stderr, flush=True)
