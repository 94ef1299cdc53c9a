"""The verbs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _midsurf
from ._arguments import (
    Coping,
    Part,
    Progress,
    Reading,
    Size,
    amount,
    coping as tags,
    figures,
    mesh,
    reading,
    rows,
    size,
    warned,
)
from ._errors import InputError
from ._mesh import CopingTags, Mesh, RoundTrip
from ._surface import MidSurface, _one_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


def extract(
    part: Part,
    *,
    coping: Coping = "auto",
    cell: Size = "auto",
    angle: float = 15.0,
    keep_fins: bool = False,
    allow_open: bool = False,
    element_size: Size | None = None,
    sag: Size | None = None,
    grading: float | None = None,
    quads: bool = False,
    junctions: str = "medial",
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    **how_read: Unpack[Reading],
) -> MidSurface:
    """Extracts the mid-surface of a part.

    The same part and settings give the same result, bit for bit, on any number of threads, and the same as
    ``midsurf extract``.

    :param part: a mesh file (or CAD file, with Gmsh), or ``(vertices, triangles)``; closed.
    :param coping: faces that close a wall: ``"auto"`` to find them, ``"none"``, a tag file, or a flag a triangle.
    :param cell: a length, ``"0.5t"`` (wall thicknesses), ``"1%"`` (of the diagonal), or ``"auto"``, the median
        wall thickness.
    :param angle: smallest angle in degrees at which a point of a sheet sees its two footpoints.
    :param keep_fins: keeps the sheets that run into convex edges of one wall.
    :param allow_open: goes on when the part has gaps; inside and outside are guesses near them.
    :param element_size: remeshes to this edge length, as ``cell``; ``sag`` (how far edges may run beside curved
        walls), ``grading`` (growth of edges), ``quads`` (pairs triangles) and ``junctions`` ("medial" or
        "straight") go with it.
    :param memory_limit: bytes, or ``"8G"``; a cell that would need more is refused.
    :param threads: by default one a processor.
    :param progress: called as ``progress(stage, done, expected)``.
    :param how_read: ``weld``, ``repair``, ``scale``, ``unit``, ``cad_sag``, ``solid``; see `Reading`.
    :raises InputError: for bad input, with the file, the place and what to do.
    :raises NoResultError: where no mid-surface was found.
    """
    surface = _midsurf.extract(
        mesh(part),
        tags(coping),
        size(cell),
        angle,
        keep_fins,
        allow_open,
        reading(how_read),
        _elements(element_size, sag, grading, quads, junctions),
        amount(memory_limit),
        _count(threads),
        progress,
    )
    return MidSurface(surface, warned(surface.warnings))


def shard(
    part: Part,
    which: tuple[int, int],
    *,
    coping: Coping = "auto",
    cell: Size = "auto",
    angle: float = 15.0,
    keep_fins: bool = False,
    allow_open: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    **how_read: Unpack[Reading],
) -> bytes:
    """Computes one piece of an extraction, apart from all others; `merge` joins them.

    The bytes are those of ``midsurf extract --shard 3/16 -o piece.shard``.

    :param which: the shard, counted from 1, and how many there are: ``(3, 16)``.

    Other arguments are those of `extract`.
    """
    index, count = which
    return _midsurf.shard(
        mesh(part),
        (_whole("which", index), _whole("which", count)),
        tags(coping),
        size(cell),
        angle,
        keep_fins,
        allow_open,
        reading(how_read),
        amount(memory_limit),
        _count(threads),
        progress,
    )


def merge(
    shards: Iterable[bytes],
    *,
    element_size: Size | None = None,
    sag: Size | None = None,
    grading: float | None = None,
    quads: bool = False,
    junctions: str = "medial",
    threads: int | None = None,
    progress: Progress | None = None,
) -> MidSurface:
    """Joins all shards of an extraction, in any order, to what `extract` makes of the whole part, bit for bit.

    Arguments are those of `extract`.

    :raises InputError: where a shard is missing, there twice, or of another part, other settings or another version.
    """
    wanted = _elements(element_size, sag, grading, quads, junctions)
    surface = _midsurf.merge(list(shards), wanted, _count(threads), progress)
    return MidSurface(surface, warned(surface.warnings))


def _elements(
    element_size: Size | None, sag: Size | None, grading: float | None, quads: bool, junctions: str
) -> tuple[str, str | None, float | None, bool, bool] | None:
    """What remeshing is told; none where it was not asked for."""
    straight = _one_of("junctions", junctions, ("medial", "straight")) == "straight"
    if element_size is not None:
        return size(element_size), None if sag is None else size(sag), grading, quads, straight
    if sag is not None or grading is not None or quads or straight:
        raise InputError("sag, grading, quads and junctions go with element_size", "give element_size")
    return None


def detect_coping(
    part: Part, *, samples: int | None = None, threads: int | None = None, **how_read: Unpack[Reading]
) -> CopingTags:
    """Finds the coping faces of a part: the narrow faces that close a wall.

    :param samples: about how many points of the surface are looked at; by default one a squared wall
        thickness, 4,000 to 8,000.
    """
    points = None if samples is None else _whole("samples", samples)
    found = _midsurf.detect_coping(mesh(part), points, reading(how_read), _count(threads))
    return CopingTags(found, warned(found.warnings))


def info(
    part: Part,
    *,
    coping: Coping = "auto",
    min_wall: float | None = None,
    threads: int | None = None,
    **how_read: Unpack[Reading],
) -> dict[str, Any]:
    """Says what a part is: triangles, closedness, volume, box, names, wall thickness and where it is thinnest.

    The same figures as ``midsurf info --json``; ``min_wall`` adds whether a wall is thinner than that.
    """
    return figures(_midsurf.info(mesh(part), tags(coping), reading(how_read), min_wall, _count(threads)))


def offset(
    part: Part,
    distance: float,
    *,
    cell: Size = "auto",
    tolerance: float | None = None,
    simplify: bool = False,
    triangles: int | None = None,
    voids: str = "keep",
    single_precision: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    **how_read: Unpack[Reading],
) -> Mesh:
    """Grows a closed part by a distance, or shrinks it by a negative one, without self-intersections.

    :param cell: a length, ``"1%"`` of the diagonal, or ``"auto"``, 256 cells along the result.
    :param tolerance: chords that stray farther from the offset are split; by default 0.2 % of the distance.
    :param simplify: fewer triangles where the offset is flat or bends one way, within the tolerance.
    :param triangles: so many triangles at most; implies ``simplify``.
    :param voids: "keep" or "fill" cavities that the part has.
    :param single_precision: chooses vertices among the numbers that an ``.stl`` holds.
    """
    closed = _closed(cell, tolerance, reading(how_read), simplify, triangles, voids, single_precision)
    how = (amount(memory_limit), _count(threads), progress)
    return _solid(_midsurf.offset(mesh(part), float(distance), closed, *how))


def hollow(
    part: Part,
    thickness: float,
    *,
    drain: Sequence[str] = (),
    open: Sequence[str] = (),
    cell: Size = "auto",
    tolerance: float | None = None,
    simplify: bool = False,
    triangles: int | None = None,
    voids: str = "keep",
    single_precision: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    **how_read: Unpack[Reading],
) -> Mesh:
    """Hollows a closed part out, leaving walls of one thickness; the outer surface stays bit for bit.

    :param drain: holes into the cavity, ``"4@10,0,0"``: a diameter and a place on the surface.
    :param open: planes beyond which all is cut away, ``"+z=30"``.

    The other arguments are those of `offset`.
    """
    closed = _closed(cell, tolerance, reading(how_read), simplify, triangles, voids, single_precision)
    how = (amount(memory_limit), _count(threads), progress)
    return _solid(_midsurf.hollow(mesh(part), float(thickness), list(drain), list(open), closed, *how))


def thicken(
    surface: Part,
    thickness: float,
    *,
    side: str = "inner",
    cell: Size = "auto",
    tolerance: float | None = None,
    single_precision: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """Makes a solid of a surface, on one side of it; the surface itself is part of the result.

    :param side: "inner", against the normals, "outer", or "both", half of the thickness on either.
    :param cell: a length, ``"1%"`` of the diagonal, or ``"auto"``, a quarter of the thickness.
    """
    if _one_of("side", side, ("inner", "outer", "both")) == "both":
        return rethicken(
            surface,
            thickness=thickness,
            cell=cell,
            tolerance=tolerance,
            single_precision=single_precision,
            memory_limit=memory_limit,
            threads=threads,
            progress=progress,
        )
    how = (amount(memory_limit), _count(threads), progress)
    return _solid(
        _midsurf.thicken(
            mesh(surface), float(thickness), side == "outer", size(cell), tolerance, single_precision, *how
        )
    )


def rethicken(
    mid: MidSurface | Part,
    *,
    thickness: float | npt.ArrayLike | str | os.PathLike[str] | None = None,
    groups: Mapping[str, float] | None = None,
    round_borders: bool = False,
    cell: Size = "auto",
    tolerance: float | None = None,
    single_precision: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """Thickens a mid-surface by its own thickness, or any shell mesh by one that is given, to both sides.

    :param mid: a `MidSurface`, a file of one, or any mesh with a ``thickness``.
    :param thickness: of any mesh: a length, or one for every triangle; of a file of a mid-surface: a table (CSV)
        instead of its own.
    :param groups: other thicknesses, by the names of groups, objects or materials of a file.
    :param round_borders: ends round at all free borders.
    :param cell: a length, ``"0.2t"`` of the median thickness, ``"1%"``, or ``"auto"``, a quarter of the least.
    """
    how = (amount(memory_limit), _count(threads), progress)
    shell = _shell(mid, thickness, list((groups or {}).items()))
    return _solid(_midsurf.rethicken(shell, round_borders, size(cell), tolerance, single_precision, *how))


def _shell(mid: Any, thickness: Any, groups: list[tuple[str, float]]) -> Any:
    """A mid-surface, or a mesh with its thickness, as the compiled half takes them."""
    is_file = isinstance(mid, (str, os.PathLike))
    if groups and not (is_file and isinstance(thickness, (int, float))):
        raise InputError("groups go with a file and one thickness for all others", "give thickness a length")
    if isinstance(mid, MidSurface):
        if thickness is None:
            return mid._surface
        mid = (mid.vertices, mid.triangles)
    if is_file:
        if thickness is None or isinstance(thickness, (str, os.PathLike)):
            return os.fspath(mid), None if thickness is None else os.fspath(thickness)
        if isinstance(thickness, (int, float)):
            return os.fspath(mid), float(thickness), groups
    if thickness is None or isinstance(thickness, (str, os.PathLike)):
        raise InputError("arrays have no thickness of their own", "give thickness a length, or one for every triangle")
    vertices, triangles = mesh(mid) if not is_file else _read(mid)
    every = np.broadcast_to(np.asarray(thickness, dtype=np.float64), (len(triangles),))
    return vertices, triangles, np.ascontiguousarray(every)


def _read(file: Any) -> Any:
    raise InputError(f"{file}: a file takes one thickness", "give thickness a length, and groups others")


def roundtrip(
    part: Part,
    *,
    coping: Coping = "auto",
    cell: Size = "auto",
    angle: float = 15.0,
    solid_cell: Size = "auto",
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    **how_read: Unpack[Reading],
) -> RoundTrip:
    """Extracts the mid-surface of a part, thickens it again, and says how far that is from the part.

    :param solid_cell: cell of the solid, as ``cell`` of `rethicken`.

    The other arguments are those of `extract`.
    """
    how = (amount(memory_limit), _count(threads), progress)
    surface, solid, comparison = _midsurf.roundtrip(
        mesh(part), tags(coping), size(cell), angle, size(solid_cell), reading(how_read), *how
    )
    mid = MidSurface(surface, warned(surface.warnings))
    return RoundTrip(mid, _solid(solid), figures(comparison))


def subdivide(
    control: str | os.PathLike[str] | tuple[npt.ArrayLike, Sequence[Sequence[int]]],
    thickness: float,
    *,
    samples: int | None = None,
    levels: int | None = None,
    tolerance: float | None = None,
    groups: Mapping[str, float] | None = None,
    scheme: str = "crust",
    boundary: str | None = None,
    cell: Size = "auto",
    single_precision: bool = False,
    memory_limit: int | str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """Makes a hollow solid of a Catmull-Clark control mesh.

    :param control: an ``.obj`` of polygons, or ``(vertices, faces)`` with the corners of every face.
    :param samples: steps along each side of a face; by default 8, fewer where semi-sharp tags ask for more levels.
    :param levels: subdivision steps before the inner surface is laid; by default 1.
    :param tolerance: instead of ``levels``: takes the first level whose wall is nowhere thinner by more than this
        and that has no fold.
    :param groups: other thicknesses, by the names of groups, objects or materials of a file.
    :param scheme: "crust", "direct", or "contour", which never folds.
    :param boundary: "corner" holds boundary vertices of a single face in place, "edge" smooths them, faces at the
        boundary have no surface with "none"; by default what the file's tag says, else "corner".
    :param cell: of the scheme "contour": a length, ``"0.5t"``, ``"1%"`` or ``"auto"``.
    """
    if levels is not None and tolerance is not None:
        raise InputError("tolerance chooses the level, and levels gives it", "give one of the two")
    if scheme == "contour" and tolerance is not None:
        raise InputError(
            "tolerance chooses a level for the crust, and the scheme contour lays none",
            "say with levels and samples how finely to divide the surface",
        )
    given: Any
    if isinstance(control, (str, os.PathLike)):
        given = os.fspath(control)
    else:
        if groups:
            raise InputError("groups go with a file that names them", "leave groups away")
        vertices, faces = control
        corners = [[int(corner) for corner in face] for face in faces]
        if any(corner < 0 or corner > 0xFFFFFFFF for face in corners for corner in face):
            raise InputError("faces name vertices that cannot be")
        given = (rows(vertices, "vertices", np.float64), corners)
    how = (amount(memory_limit), _count(threads), progress)
    levels = None if levels is None else _whole("levels", levels)
    samples = None if samples is None else _whole("samples", samples)
    return _solid(
        _midsurf.subdivide(
            given,
            float(thickness),
            samples,
            levels,
            tolerance,
            scheme,
            boundary,
            list((groups or {}).items()),
            size(cell),
            single_precision,
            *how,
        )
    )


def _closed(
    cell: Size,
    tolerance: float | None,
    read: tuple[Any, ...],
    simplify: bool,
    triangles: int | None,
    voids: str,
    single: bool,
) -> tuple[str, float | None, tuple[Any, ...], bool, int | None, bool, bool]:
    fill = _one_of("voids", voids, ("keep", "fill")) == "fill"
    return size(cell), tolerance, read, simplify, triangles, fill, single


def _solid(made: tuple[Any, ...]) -> Mesh:
    vertices, triangles, thickness, report, warnings = made
    return Mesh(vertices, triangles, thickness, figures(report), warned(warnings, 4))


def _whole(name: str, given: int) -> int:
    if given < 0 or given > 0xFFFFFFFF:
        raise InputError(f"{name}: expected a whole number that is not negative")
    return int(given)


def _count(threads: int | None) -> int | None:
    if threads is not None and not 1 <= threads <= 1024:
        raise InputError("threads: expected a number from 1 to 1024")
    return threads
