"""The mid-surface as Python sees it."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _midsurf
from ._arguments import Warning, figures

if TYPE_CHECKING:
    import meshio
    import pyvista

#: Words for the numbers of `MidSurface.kind`.
KINDS = ("sheet", "seam", "junction", "coping border", "fading border")


class Seam(NamedTuple):
    """A curve where three or more sheet sides meet."""

    path: npt.NDArray[np.uint32]
    """Vertices in order."""
    sheets: tuple[int, ...]
    """Sheets at the seam, each once for every side."""
    closed: bool
    """Whether the last vertex is joined to the first."""


class Border(NamedTuple):
    """A piece of the free boundary of a sheet."""

    path: npt.NDArray[np.uint32]
    """Vertices in order."""
    sheet: int
    """The sheet that ends here."""
    kind: str
    """``"coping"``, where it leaves the part through a coping face, or ``"fading"``."""
    closed: bool
    """Whether the last vertex is joined to the first."""


class Crease(NamedTuple):
    """A line along which a sheet bends."""

    path: npt.NDArray[np.uint32]
    """Vertices in order."""
    sheet: int
    """The sheet that bends here."""
    closed: bool
    """Whether the last vertex is joined to the first."""


class MidSurface:
    """A mid-surface: one connected, non-manifold triangle mesh of sheets, with the wall thickness at every vertex.

    Arrays are views into the surface's own memory and cannot be written to; copy them to change them. A surface can
    be pickled; a copy made so does not know its part, so that it cannot be saved as a shell model.
    """

    def __init__(self, surface: _midsurf.Surface, warnings: list[Warning] | None = None) -> None:
        self._surface = surface
        self.warnings: list[Warning] = warnings if warnings is not None else []
        """What is odd about the part or the result."""

    @classmethod
    def read(cls, file: str | os.PathLike[str]) -> MidSurface:
        """Reads a mid-surface that was saved as ``.ply``, or as ``.obj`` with its table of thickness.

        Footpoints are not in such files.
        """
        surface = _midsurf.read(os.fspath(file))
        return cls(surface, [Warning(*pair) for pair in surface.warnings])

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """Positions, ``(n, 3)``."""
        return self._surface.vertices

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """Corners, ``(m, 3)``; one orientation a sheet."""
        return self._surface.triangles

    @property
    def thickness(self) -> npt.NDArray[np.float64]:
        """Wall thickness at every vertex: the largest distance between two of its footpoints."""
        return self._surface.thickness

    @property
    def radius(self) -> npt.NDArray[np.float64]:
        """Radius at every vertex of the ball that touches the walls; more than half the thickness near seams."""
        return self._surface.radius

    @property
    def sheet(self) -> npt.NDArray[np.uint32]:
        """The sheet of every triangle."""
        return self._surface.sheet

    @property
    def sheet_count(self) -> int:
        """Number of sheets."""
        return self._surface.sheet_count

    @cached_property
    def kind(self) -> npt.NDArray[np.uint8]:
        """What every vertex is, a place in `KINDS`."""
        return self._surface.kind

    @cached_property
    def footpoints(self) -> npt.NDArray[np.float64]:
        """Two nearest wall points of every vertex, the farthest apart, ``(n, 2, 3)``; NaN where they are not known.

        A vertex on a seam has more than two; see `all_footpoints`.
        """
        return self._surface.footpoints

    @cached_property
    def all_footpoints(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint64]]:
        """All footpoints, ``(k, 3)``, and where those of each vertex begin, ``(n + 1,)``."""
        return self._surface.all_footpoints

    @cached_property
    def seams(self) -> list[Seam]:
        """Curves where sheets meet."""
        return [Seam(path, tuple(sheets), closed) for path, sheets, closed, _ in self._surface.seams]

    @cached_property
    def borders(self) -> list[Border]:
        """The free boundary."""
        return [Border(path, sheets[0], kind or "", closed) for path, sheets, closed, kind in self._surface.borders]

    @cached_property
    def creases(self) -> list[Crease]:
        """Lines along which sheets bend."""
        return [Crease(path, sheets[0], closed) for path, sheets, closed, _ in self._surface.creases]

    @cached_property
    def junctions(self) -> npt.NDArray[np.uint32]:
        """Vertices where seams meet or end."""
        return self._surface.junctions

    @cached_property
    def quads(self) -> npt.NDArray[np.uint32]:
        """Pairs of triangles that make quadrilaterals, ``(q, 2)``."""
        return self._surface.quads

    @cached_property
    def cracks(self) -> npt.NDArray[np.float64]:
        """Places where something is missing, ``(c, 3)``; none in a sound result."""
        return self._surface.cracks

    @property
    def cell(self) -> float | None:
        """The cell that was used; none of a surface that was read or sent."""
        return self._surface.cell

    @cached_property
    def report(self) -> dict[str, Any]:
        """Figures: counts, areas, lengths, thickness, quality, sheets; as ``result`` of ``midsurf extract --json``."""
        return figures(self._surface.report())

    def listing(self) -> str:
        """All sheets, seams, borders and junctions in words, sorted by place."""
        return self._surface.listing()

    def save(
        self,
        file: str | os.PathLike[str],
        *,
        obj_lines: bool = False,
        order: int | None = None,
        dialect: str = "calculix",
        template: str | None = None,
        placement: float = 0.5,
    ) -> None:
        """Writes the surface; the suffix tells the format.

        ``.ply`` and ``.vtu`` hold thickness, radius, sheets and lines; ``.obj`` one group a sheet, with
        NAME.thickness.csv beside it, and lines if ``obj_lines``; ``.stl`` triangles alone. ``.inp``, ``.bdf``,
        ``.msh`` and ``.glb`` are shell models: ``order`` 1 or 2 of the elements, ``dialect`` "calculix" or "abaqus",
        ``template`` "cantilever" or "modal" for a deck ready to solve, ``placement`` of the nodes from 0 on one wall
        to 1 on the other. A file appears complete or not at all.
        """
        abaqus = _one_of("dialect", dialect, ("calculix", "abaqus")) == "abaqus"
        self._surface.save(os.fspath(file), obj_lines, order, abaqus, template, placement)

    def to_pyvista(self) -> pyvista.PolyData:
        """The surface for PyVista, with ``thickness``, ``radius`` and ``kind`` at points, ``sheet`` at cells."""
        import pyvista

        faces = np.column_stack((np.full(len(self.triangles), 3), self.triangles)).ravel()
        mesh = pyvista.PolyData(np.ascontiguousarray(self.vertices), faces)
        for name, values in self._point_data().items():
            mesh.point_data[name] = values
        mesh.cell_data["sheet"] = np.ascontiguousarray(self.sheet)
        return mesh

    def to_meshio(self) -> meshio.Mesh:
        """The surface for meshio, with the same data."""
        import meshio

        return meshio.Mesh(
            np.ascontiguousarray(self.vertices),
            [("triangle", self.triangles.astype(np.int64))],
            point_data=self._point_data(),
            cell_data={"sheet": [np.ascontiguousarray(self.sheet)]},
        )

    def _point_data(self) -> dict[str, npt.NDArray[Any]]:
        return {
            "thickness": np.ascontiguousarray(self.thickness),
            "radius": np.ascontiguousarray(self.radius),
            "kind": self.kind,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        # Views lose what they look at: whole copies go.
        pieces = _whole(self._surface.pieces())
        return _rebuilt, (pieces, self.warnings)

    def __repr__(self) -> str:
        return (
            f"<MidSurface: {len(self.vertices)} vertices, {len(self.triangles)} triangles, "
            f"{self.sheet_count} sheets, {len(self.seams)} seams, {len(self.borders)} borders>"
        )


def _rebuilt(pieces: tuple[Any, ...], warnings: list[Warning]) -> MidSurface:
    return MidSurface(_midsurf.Surface.of_pieces(*pieces), warnings)


def _whole(value: Any) -> Any:
    """The same with contiguous arrays."""
    if isinstance(value, np.ndarray):
        return np.ascontiguousarray(value)
    if isinstance(value, (tuple, list)):
        return type(value)(_whole(item) for item in value)
    return value


def _one_of(name: str, given: str, known: tuple[str, ...]) -> str:
    from ._errors import InputError

    if given not in known:
        raise InputError(f"{name}: expected {' or '.join(map(repr, known))}, not {given!r}")
    return given
