"""Mid-surface of a thin-wall part as one connected, crack-free, non-manifold triangle mesh with thickness.

>>> import midsurf
>>> mid = midsurf.extract("part.stl", cell="0.5t")  # doctest: +SKIP
>>> mid.vertices, mid.triangles, mid.thickness, mid.sheet  # doctest: +SKIP
>>> mid.save("mid.vtu")  # doctest: +SKIP

Functions take files or arrays, let other Python threads run while they work, heed Ctrl-C, and report progress. Folders
of parts on many machines: `midsurf.dask`.
"""

from ._midsurf import __version__
from ._arguments import Coping, Part, Progress, Reading, Size, Warning
from ._errors import Error, InputError, NoResultError, PartWarning
from ._functions import (
    detect_coping,
    extract,
    hollow,
    info,
    merge,
    offset,
    rethicken,
    roundtrip,
    shard,
    subdivide,
    thicken,
)
from ._mesh import CopingTags, Mesh, RoundTrip
from ._surface import KINDS, Border, Crease, MidSurface, Seam

__all__ = [
    "KINDS",
    "Border",
    "Coping",
    "CopingTags",
    "Crease",
    "Error",
    "InputError",
    "Mesh",
    "MidSurface",
    "NoResultError",
    "Part",
    "PartWarning",
    "Progress",
    "Reading",
    "RoundTrip",
    "Seam",
    "Size",
    "Warning",
    "__version__",
    "detect_coping",
    "extract",
    "hollow",
    "info",
    "merge",
    "offset",
    "rethicken",
    "roundtrip",
    "shard",
    "subdivide",
    "thicken",
]
