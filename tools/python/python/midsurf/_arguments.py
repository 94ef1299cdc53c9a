"""Arguments as people give them, made what the compiled half takes."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypedDict, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError, PartWarning

#: A mesh: a file, ``(vertices, triangles)``, or anything with ``vertices`` and ``triangles`` or ``faces``,
#: as a `Mesh` or a trimesh has them.
Part = Union[str, "os.PathLike[str]", "tuple[npt.ArrayLike, npt.ArrayLike]", Any]

#: Coping tags: ``"auto"`` to find them, ``"none"``, a tag file, or a flag for every triangle.
Coping = Union[str, "os.PathLike[str]", npt.ArrayLike]

#: A length in the units of the part, or ``"0.5t"`` (wall thicknesses), ``"1%"`` (of the diagonal), ``"auto"``.
Size = Union[float, str]

#: Called as ``progress(stage, done, expected)``, in the calling thread; both numbers are 0 where they are not known.
#: An exception ends the work.
Progress = Callable[[str, int, int], object]


class Warning(NamedTuple):
    """What is odd: a code that stays, and words."""

    code: str
    message: str


def mesh(part: Part) -> Any:
    """A file's name, or vertices and triangles as arrays that need no more copies."""
    if isinstance(part, (str, os.PathLike)):
        return os.fspath(part)
    if isinstance(part, (tuple, list)) and len(part) == 2:
        vertices, triangles = part
    elif hasattr(part, "vertices") and (hasattr(part, "triangles") or hasattr(part, "faces")):
        vertices = part.vertices
        triangles = part.triangles if hasattr(part, "triangles") else part.faces
    else:
        raise InputError(
            f"a part is a file or a pair of arrays, not {type(part).__name__}",
            "give a path, or (vertices, triangles)",
        )
    return rows(vertices, "vertices", np.float64), rows(triangles, "triangles", np.uint32)


def rows(given: npt.ArrayLike, name: str, kind: type[np.generic]) -> npt.NDArray[Any]:
    """An array of rows of three numbers."""
    array = np.asarray(given)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{name} has shape {array.shape}, expected (n, 3)")
    if kind is np.uint32 and array.dtype != np.uint32:
        if not np.issubdtype(array.dtype, np.integer):
            raise InputError(f"{name} holds {array.dtype}, expected whole numbers")
        if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
            raise InputError(f"{name} names vertices that cannot be: {array.min()} to {array.max()}")
    try:
        return np.asarray(array, dtype=kind)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} holds {array.dtype}, expected numbers") from error


def coping(given: Coping) -> Any:
    """A word, a file's name, or an array of flags."""
    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    flags = np.asarray(given)
    if flags.ndim != 1 or flags.dtype != np.bool_:
        raise InputError(
            f"coping is an array of {flags.dtype} of shape {flags.shape}, expected one flag for every triangle",
            'give booleans, "auto", "none" or a tag file',
        )
    return flags


class Reading(TypedDict, total=False):
    """What is done to a part as it is read; every function that takes a part takes these.

    ``weld`` merges vertices within this distance. ``repair`` puts right also what takes a guess. ``scale`` multiplies
    the coordinates. ``unit`` ("mm", "in", ...) is for reports. ``cad_sag`` is how far chords of a CAD model may lie
    off its faces. ``solid`` takes one of several solids, by number from 1 or name.
    """

    weld: float | None
    repair: bool
    scale: float | None
    unit: str | None
    cad_sag: Size | None
    solid: str | int | None


def reading(given: Reading) -> tuple[Any, ...]:
    """The same as the compiled half takes it."""
    unknown = set(given) - set(Reading.__annotations__)
    if unknown:
        raise TypeError(f"unexpected keyword argument {min(unknown)!r}")
    sag, solid = given.get("cad_sag"), given.get("solid")
    return (
        given.get("weld"),
        given.get("repair", False),
        given.get("scale"),
        given.get("unit"),
        None if sag is None else size(sag),
        None if solid in (None, "all") else str(solid),
    )


def size(given: Size) -> str:
    """A cell size as the command reads it."""
    return given if isinstance(given, str) else repr(float(given))


def amount(given: int | str | None) -> str | None:
    """An amount of memory as the command reads it."""
    return None if given is None else str(given)


def warned(pairs: Sequence[tuple[str, str]], level: int = 3) -> list[Warning]:
    """Issues warnings to whoever called the package, so many calls up, and gives them back."""
    told = [Warning(*pair) for pair in pairs]
    for warning in told:
        warnings.warn(warning.message, PartWarning, stacklevel=level)
    return told


def figures(text: str) -> dict[str, Any]:
    """Figures out of the compiled half."""
    read: dict[str, Any] = json.loads(text)
    return read
