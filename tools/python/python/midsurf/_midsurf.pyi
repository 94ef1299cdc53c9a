"""The compiled half: what the package's functions and classes stand on. Arguments are checked there."""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float64]
_Ints = npt.NDArray[np.uint32]
_Mesh = str | tuple[_Floats, _Ints]
_Line = tuple[_Ints, list[int], bool, str | None]
_Solid = tuple[_Floats, _Ints, _Floats | None, str, list[tuple[str, str]]]
_Reading = tuple[Any, ...]
_Closed = tuple[str, float | None, _Reading, bool, int | None, bool, bool]
_Progress = Callable[[str, int, int], object] | None

__version__: str

class Surface:
    @property
    def vertices(self) -> _Floats: ...
    @property
    def triangles(self) -> _Ints: ...
    @property
    def thickness(self) -> _Floats: ...
    @property
    def radius(self) -> _Floats: ...
    @property
    def sheet(self) -> _Ints: ...
    @property
    def sheet_count(self) -> int: ...
    @property
    def kind(self) -> npt.NDArray[np.uint8]: ...
    @property
    def footpoints(self) -> _Floats: ...
    @property
    def all_footpoints(self) -> tuple[_Floats, npt.NDArray[np.uint64]]: ...
    @property
    def seams(self) -> list[_Line]: ...
    @property
    def borders(self) -> list[_Line]: ...
    @property
    def creases(self) -> list[_Line]: ...
    @property
    def junctions(self) -> _Ints: ...
    @property
    def quads(self) -> _Ints: ...
    @property
    def cracks(self) -> _Floats: ...
    @property
    def cell(self) -> float | None: ...
    @property
    def warnings(self) -> list[tuple[str, str]]: ...
    def report(self) -> str: ...
    def listing(self) -> str: ...
    def save(
        self,
        file: str | os.PathLike[str],
        obj_lines: bool,
        order: int | None,
        abaqus: bool,
        template: str | None,
        placement: float,
    ) -> None: ...
    def pieces(self) -> tuple[Any, ...]: ...
    @staticmethod
    def of_pieces(*pieces: Any) -> Surface: ...

class Tags:
    @property
    def flags(self) -> npt.NDArray[np.bool_]: ...
    @property
    def questions(self) -> list[str]: ...
    @property
    def warnings(self) -> list[tuple[str, str]]: ...
    def report(self) -> str: ...
    def save(self, file: str | os.PathLike[str]) -> None: ...

def extract(
    part: _Mesh,
    coping: str | npt.NDArray[np.bool_],
    cell: str,
    angle: float,
    keep_fins: bool,
    allow_open: bool,
    preparing: _Reading,
    wanted: tuple[str, str | None, float | None, bool, bool] | None,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> Surface: ...
def shard(
    part: _Mesh,
    which: tuple[int, int],
    coping: str | npt.NDArray[np.bool_],
    cell: str,
    angle: float,
    keep_fins: bool,
    allow_open: bool,
    preparing: _Reading,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> bytes: ...
def merge(
    shards: list[bytes],
    wanted: tuple[str, str | None, float | None, bool, bool] | None,
    threads: int | None,
    progress: _Progress,
) -> Surface: ...
def read(file: str | os.PathLike[str]) -> Surface: ...
def detect_coping(part: _Mesh, samples: int | None, preparing: _Reading, threads: int | None) -> Tags: ...
def info(
    part: _Mesh,
    coping: str | npt.NDArray[np.bool_],
    preparing: _Reading,
    min_wall: float | None,
    threads: int | None,
) -> str: ...
def offset(
    part: _Mesh,
    distance: float,
    closed: _Closed,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> _Solid: ...
def hollow(
    part: _Mesh,
    thickness: float,
    drains: list[str],
    cuts: list[str],
    closed: _Closed,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> _Solid: ...
def thicken(
    surface: _Mesh,
    thickness: float,
    outer: bool,
    cell: str,
    tolerance: float | None,
    single: bool,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> _Solid: ...
def rethicken(
    shell: Any,
    rounded: bool,
    cell: str,
    tolerance: float | None,
    single: bool,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> _Solid: ...
def roundtrip(
    part: _Mesh,
    coping: str | npt.NDArray[np.bool_],
    cell: str,
    angle: float,
    solid_cell: str,
    preparing: _Reading,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> tuple[Surface, _Solid, str]: ...
def subdivide(
    control: str | tuple[_Floats, list[list[int]]],
    thickness: float,
    samples: int | None,
    levels: int | None,
    tolerance: float | None,
    named: str,
    boundary: str | None,
    groups: list[tuple[str, float]],
    cell: str,
    single: bool,
    memory_limit: str | None,
    threads: int | None,
    progress: _Progress,
) -> _Solid: ...
def save_solid(
    file: str | os.PathLike[str], vertices: _Floats, triangles: _Ints, thickness: _Floats | None
) -> None: ...
