"""Solids, and the other results."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _midsurf
from ._arguments import Warning, figures
from ._surface import MidSurface

if TYPE_CHECKING:
    import meshio
    import pyvista


class Mesh:
    """A triangle mesh, mostly of a solid: closed, every triangle counter-clockwise from outside."""

    def __init__(
        self,
        vertices: npt.NDArray[np.float64],
        triangles: npt.NDArray[np.uint32],
        thickness: npt.NDArray[np.float64] | None = None,
        report: dict[str, Any] | None = None,
        warnings: list[Warning] | None = None,
    ) -> None:
        self.vertices = vertices
        """Positions, ``(n, 3)``."""
        self.triangles = triangles
        """Corners, ``(m, 3)``."""
        self.thickness = thickness
        """Distance of every vertex to the other side of the wall, where the function measures it."""
        self.report: dict[str, Any] = report if report is not None else {}
        """Figures of the function that made it."""
        self.warnings: list[Warning] = warnings if warnings is not None else []
        """What is odd about the input or the result."""

    @property
    def volume(self) -> float:
        """Enclosed volume."""
        if not len(self.triangles):
            return 0.0
        corners = (self.vertices - self.vertices.mean(axis=0))[self.triangles]
        return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)

    @property
    def area(self) -> float:
        """Area of all triangles."""
        a, b, c = (self.vertices[self.triangles[:, corner]] for corner in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes ``.stl``, ``.obj`` or ``.ply``, the last with the thickness. An ``.stl`` has single precision:
        functions that take ``single_precision`` choose vertices among such numbers, so that rounding cuts nothing.
        """
        _midsurf.save_solid(os.fspath(file), self.vertices, self.triangles, self.thickness)

    def to_pyvista(self) -> pyvista.PolyData:
        """The mesh for PyVista."""
        import pyvista

        faces = np.column_stack((np.full(len(self.triangles), 3), self.triangles)).ravel()
        mesh = pyvista.PolyData(self.vertices, faces)
        if self.thickness is not None:
            mesh.point_data["thickness"] = self.thickness
        return mesh

    def to_meshio(self) -> meshio.Mesh:
        """The mesh for meshio."""
        import meshio

        data = {} if self.thickness is None else {"thickness": self.thickness}
        return meshio.Mesh(self.vertices, [("triangle", self.triangles.astype(np.int64))], point_data=data)

    def __repr__(self) -> str:
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


class RoundTrip:
    """A part to its mid-surface, back to a solid, and how far that is off."""

    def __init__(self, mid: MidSurface, solid: Mesh, comparison: dict[str, Any]) -> None:
        self.mid = mid
        """The mid-surface."""
        self.solid = solid
        """The solid of its balls."""
        self.comparison = comparison
        """Distances both ways, volume and area ratios; as ``comparison`` of ``midsurf roundtrip --json``."""

    def __repr__(self) -> str:
        return f"<RoundTrip: volume ratio {self.comparison['volume_ratio']:.5f}>"


class CopingTags:
    """Coping faces that the program found."""

    def __init__(self, tags: _midsurf.Tags, warnings: list[Warning]) -> None:
        self._tags = tags
        self.flags: npt.NDArray[np.bool_] = tags.flags
        """One flag a triangle: true for coping. `extract` takes them as ``coping``."""
        self.questions: list[str] = tags.questions
        """What is not sure, gravest first."""
        self.report: dict[str, Any] = figures(tags.report())
        """Every face with score and reasons; as ``result`` of ``midsurf tags detect --json``."""
        self.warnings = warnings
        """What was odd about the file."""

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes an ordinary tag file, to edit and give as ``coping``: TOML if the name ends in .toml, else text."""
        self._tags.save(os.fspath(file))

    def __repr__(self) -> str:
        return f"<CopingTags: {int(self.flags.sum())} of {len(self.flags)} triangles, {len(self.questions)} questions>"
