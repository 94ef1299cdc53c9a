#!/usr/bin/env python3
"""Pictures of a mid-surface: sheets in distinct colours, seams as thick red
lines, coping borders blue, fading borders green, other free edges black.

    render.py MID.obj picture.png
    render.py MID.ply picture.png --part PART.obj --view iso --view=-1,-1,0.4
    render.py MID.ply junction.png --zoom 10,20,0,5 --edges

A PLY whose vertices have colours, such as a map of the thickness or of the
deviation, is drawn in those, without lines.

Reads the OBJ and PLY files that `midsurf extract` writes. An OBJ tells fading
borders from coping borders only if it was written with --obj-lines; a PLY always
does. Of other meshes, sheets are found by flood fill over edges of two triangles.

Needs numpy and pyvista (pip install pyvista), on a machine without a display
also OSMesa or EGL (apt-get install libosmesa6 libgl1).
"""
import argparse
import colorsys
import sys

import numpy as np

SEAM, COPING, FADING, OTHER = (0.85, 0.05, 0.05), (0.1, 0.3, 0.9), (0.05, 0.6, 0.2), (0.0, 0.0, 0.0)
VIEWS = {
    "iso": (1, -1.2, 0.9), "back": (-1, 1.2, 0.9), "below": (0.7, -1, -0.9), "x": (1, 0, 0), "y": (0, -1, 0),
    "z": (0, 0, 1),
}
PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}


class Mesh:
    """Points (n, 3), triangles (m, 3), a sheet per triangle or None, the set of
    fading edges (low, high) or None if the file does not tell, a colour per
    point (n, 3) or None."""

    colours = None

    def __init__(self, points, triangles, sheets=None, fading=None):
        self.points = np.asarray(points, float).reshape(-1, 3)
        self.triangles = np.asarray(triangles, np.int64).reshape(-1, 3)
        self.sheets = None if sheets is None else np.asarray(sheets, int)
        self.fading = fading


def read_obj(path):
    points, triangles, sheets, groups, fading = [], [], [], {}, set()
    group, lines = "", False
    with open(path, encoding="utf-8", errors="replace") as file:
        for row in file:
            word = row.split()
            if not word or word[0].startswith("#"):
                continue
            if word[0] == "v":
                points.append([float(x) for x in word[1:4]])
            elif word[0] in "go" and len(word[0]) == 1:
                group = " ".join(word[1:])
            elif word[0] == "f":
                corners = [int(w.split("/")[0]) for w in word[1:]]
                corners = [c - 1 if c > 0 else len(points) + c for c in corners]
                for k in range(1, len(corners) - 1):
                    triangles.append([corners[0], corners[k], corners[k + 1]])
                    sheets.append(groups.setdefault(group, len(groups)))
            elif word[0] == "l":
                lines = True
                ends = [int(w) - 1 for w in word[1:]]
                if group.startswith("fading"):
                    fading |= {(min(e), max(e)) for e in zip(ends, ends[1:])}
    named = any(g.startswith("sheet_") for g in groups)
    return Mesh(points, triangles, sheets if named else None, fading if lines else None)


def read_ply(path):
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    elements, form = [], None
    for row in data[:end].decode("ascii", "replace").splitlines():
        word = row.split()
        if word[0] == "format":
            form = word[1]
        elif word[0] == "element":
            elements.append((word[1], int(word[2]), []))
        elif word[0] == "property":
            elements[-1][2].append(word[1:])
    if form != "binary_little_endian":
        raise ValueError(f"{path}: only binary little-endian PLY is read")
    tables = {}
    for name, count, properties in elements:
        fields = []
        for p in properties:
            if p[0] == "list":
                # All faces are triangles here.
                fields += [("count", "<" + PLY_TYPES[p[1]]), ("corners", "<" + PLY_TYPES[p[2]], 3)]
            else:
                fields.append((p[1], "<" + PLY_TYPES[p[0]]))
        kind = np.dtype(fields)
        tables[name] = np.frombuffer(data, kind, count, end)
        end += count * kind.itemsize
    v, f = tables["vertex"], tables["face"]
    if len(f) and not (f["count"] == 3).all():
        raise ValueError(f"{path}: a face that is no triangle")
    mesh = Mesh(np.stack([v["x"], v["y"], v["z"]], 1), f["corners"])
    if "sheet" in f.dtype.names:
        mesh.sheets = f["sheet"].astype(int)
    if "red" in v.dtype.names:
        mesh.colours = np.stack([v["red"], v["green"], v["blue"]], 1)
    if "kind" in v.dtype.names:
        kinds = v["kind"]
        edges, _ = edge_counts(mesh.triangles)
        mesh.fading = {(a, b) for a, b in edges.tolist() if 4 in (kinds[a], kinds[b])}
    return mesh


def read(path):
    return read_ply(path) if path.lower().endswith(".ply") else read_obj(path)


def edge_counts(triangles):
    """Edges (low, high) and how many triangles each has."""
    all_edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if not len(all_edges):
        return all_edges, np.zeros(0, int)
    return np.unique(all_edges, axis=0, return_counts=True)


def flood(triangles):
    """A label per triangle: connected over edges of two triangles."""
    parent = list(range(len(triangles)))

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    at = {}
    for t, (a, b, c) in enumerate(triangles.tolist()):
        for e in ((a, b), (b, c), (c, a)):
            at.setdefault((min(e), max(e)), []).append(t)
    for users in at.values():
        if len(users) == 2:
            parent[root(users[0])] = root(users[1])
    roots = [root(i) for i in range(len(triangles))]
    label = {r: k for k, r in enumerate(dict.fromkeys(roots))}
    return np.array([label[r] for r in roots], int)


def sheet_colours(count):
    """Distinct light colours, neighbours in number far apart in hue."""
    golden = 0.61803398875
    shades = [(0.22, 0.95), (0.5, 0.9), (0.35, 1.0)]
    rows = [colorsys.hsv_to_rgb((0.57 + k * golden) % 1.0, *shades[k % 3]) for k in range(max(count, 1))]
    return (np.array(rows) * 255).astype(np.uint8)


def crop(mesh, centre, radius):
    """Triangles with a corner in the ball, and those that pass through it."""
    corners = mesh.points[mesh.triangles] - centre
    near = (np.linalg.norm(corners, axis=2) < radius).any(1)
    near |= np.linalg.norm(corners.mean(1), axis=1) < radius
    sheets = None if mesh.sheets is None else mesh.sheets[near]
    return Mesh(mesh.points, mesh.triangles[near], sheets, mesh.fading)


def segments(points, edges):
    """Line set of pyvista."""
    import pyvista

    rows = np.hstack([np.full((len(edges), 1), 2), edges]).astype(np.int64)
    lines = pyvista.PolyData()
    lines.points = points
    lines.lines = rows.ravel()
    return lines


def draw(plotter, mesh, options, part, lift):
    """Adds everything to the plotter; lines are moved by `lift`, towards the
    camera, lest the surfaces that they bound swallow half of their width."""
    import pyvista

    if mesh.colours is not None:
        table = np.hstack([np.full((len(mesh.triangles), 1), 3), mesh.triangles]).ravel()
        surface = pyvista.PolyData(mesh.points, table)
        surface.point_data["rgb"] = mesh.colours
        plotter.add_mesh(surface, scalars="rgb", rgb=True, ambient=0.5, diffuse=0.55, specular=0.0)
        return
    edges, counts = edge_counts(mesh.triangles)
    if mesh.sheets is None:
        mesh.sheets = flood(mesh.triangles)
    zoom = options.zoom
    shown = crop(mesh, np.array(zoom[:3]), zoom[3]) if zoom else mesh
    table = np.hstack([np.full((len(shown.triangles), 1), 3), shown.triangles]).ravel()
    surface = pyvista.PolyData(mesh.points, table)
    surface.cell_data["rgb"] = sheet_colours(int(mesh.sheets.max(initial=0)) + 1)[shown.sheets]
    plotter.add_mesh(
        surface, scalars="rgb", rgb=True, show_edges=options.edges, edge_color=(0.3, 0.3, 0.3), line_width=1,
        ambient=0.5, diffuse=0.55, specular=0.0,
    )
    free = [tuple(e) for e in edges[counts == 1].tolist()]
    fading = mesh.fading
    parts = [(edges[counts > 2], SEAM)]
    if fading is None:
        parts.append((np.array(free).reshape(-1, 2), OTHER))
    else:
        parts.append((np.array([e for e in free if e not in fading]).reshape(-1, 2), COPING))
        parts.append((np.array([e for e in free if e in fading]).reshape(-1, 2), FADING))
    for lines, colour in parts:
        if zoom and len(lines):
            middle = mesh.points[lines].mean(1)
            lines = lines[np.linalg.norm(middle - zoom[:3], axis=1) < zoom[3]]
        if len(lines):
            width = options.lines * (1.4 if colour == SEAM else 1.0)
            plotter.add_mesh(segments(mesh.points + lift, lines), color=colour, line_width=width, lighting=False)
    if part is not None:
        table = np.hstack([np.full((len(part.triangles), 1), 3), part.triangles]).ravel()
        plotter.add_mesh(
            pyvista.PolyData(part.points, table), color=(0.6, 0.65, 0.7), opacity=options.opacity, lighting=True
        )


def look(plotter, way, options, points):
    """Places the camera so that all points, or the ball of the zoom, fill the
    view; returns the size of a pixel."""
    way = np.array(way, float) / np.linalg.norm(way)
    up = np.array((0, 0, 1) if abs(way[2]) < 0.95 else (0, 1, 0), float)
    right = np.cross(up, way)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(way, right), way])
    flat = points @ axes.T
    middle, half = (flat.min(0) + flat.max(0)) / 2, (flat.max(0) - flat.min(0)) / 2
    if options.zoom:
        middle, half = axes @ np.array(options.zoom[:3]), np.full(3, options.zoom[3])
    width, height = options.size
    far = 4 * np.linalg.norm(half) + 1e-9
    centre = middle @ axes
    plotter.camera.parallel_projection = True
    plotter.camera.position = centre + way * far
    plotter.camera.focal_point = centre
    plotter.camera.up = axes[1]
    plotter.camera.parallel_scale = 1.04 * max(half[1], half[0] * height / width)
    plotter.camera.clipping_range = (0.01 * far, 3 * far)
    return 2 * plotter.camera.parallel_scale / height


def numbers(text, count):
    values = [float(x) for x in text.split(",")]
    if len(values) != count:
        raise argparse.ArgumentTypeError(f"expected {count} numbers with commas between")
    return values


def size(text):
    width, height = text.lower().split("x")
    return int(width), int(height)


def view(text):
    return VIEWS[text] if text in VIEWS else numbers(text, 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mid", help="mid-surface, .obj or .ply")
    parser.add_argument("picture", help="PNG to write")
    parser.add_argument("--part", help="draw the part around it, translucent")
    parser.add_argument("--opacity", type=float, default=0.15, help="of the part")
    parser.add_argument("--view", type=view, action="append", metavar="X,Y,Z",
                        help=f"direction from which to look, or {', '.join(VIEWS)}; repeat for several side by side")
    parser.add_argument("--zoom", type=lambda t: numbers(t, 4), metavar="X,Y,Z,R", help="only what lies in this ball")
    parser.add_argument("--edges", action="store_true", help="draw triangle edges")
    parser.add_argument("--lines", type=float, default=4.0, help="width of borders in pixels")
    parser.add_argument("--size", type=size, default=(1000, 800), metavar="WxH", help="pixels of one view")
    parser.add_argument("--colours", type=int, default=0, help="reduce the PNG to so many colours")
    options = parser.parse_args()
    try:
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger
    except ImportError:
        print("render: pyvista is missing: pip install pyvista", file=sys.stderr)
        return 2
    # It complains of a missing display before it goes on without one.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        mesh = read(options.mid)
        part = read_obj(options.part) if options.part else None
    except (OSError, ValueError) as error:
        print(f"render: {error}", file=sys.stderr)
        return 2
    views = options.view or [VIEWS["iso"]]
    width, height = options.size
    plotter = pyvista.Plotter(
        off_screen=True, shape=(1, len(views)), window_size=(width * len(views), height), border=False
    )
    plotter.enable_anti_aliasing("ssaa")
    points = part.points if part else mesh.points[np.unique(mesh.triangles)]
    for column, way in enumerate(views):
        plotter.subplot(0, column)
        plotter.set_background("white")
        pixel = look(plotter, way, options, points)
        draw(plotter, mesh, options, part, 2 * options.lines * pixel * np.array(way) / np.linalg.norm(way))
    plotter.screenshot(options.picture)
    plotter.close()
    if options.colours:
        from PIL import Image

        Image.open(options.picture).convert("RGB").quantize(options.colours).save(options.picture, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
