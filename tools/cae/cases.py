"""Parts with a known answer: closed sections swept along an axis.

A case is a section polygon in (u, v) whose sides have names, swept along w, clamped on one
face and loaded on another. Sides named ``coping_*`` and both end caps are coping faces.
Lengths in mm, forces in N, steel of 210 GPa, 0.3 and 7.85e-9 t/mm3.

The solid's figures come from ``reference.py``: ten-node tetrahedra in CalculiX.
"""
import math
from dataclasses import dataclass, field

import numpy as np

E_MODULUS, POISSON, DENSITY = 210000.0, 0.3, 7.85e-9


@dataclass
class Case:
    name: str
    section: list                 # (u, v) in order, area to the left
    sides: list                   # name of the side that leaves each corner
    length: float
    frame: str                    # world axes of u, v, w
    thickness: float
    clamp: str                    # coping face that is held
    loads: dict                   # name of a load -> (coping face, force)
    solid: dict = field(default_factory=dict)

    def xyz(self, u, v, w):
        at = dict(zip(self.frame, (u, v, w)))
        return np.array([at[a] for a in "xyz"], float)


def plate():
    return Case("plate", [(0, 0), (100, 0), (100, 2), (0, 2)],
                ["wall_bottom", "coping_tip", "wall_top", "coping_root"], 20, "xzy", 2.0,
                "coping_root", {"down": ("coping_tip", (0, 0, -10))})


def taper():
    return Case("taper", [(0, -1.5), (100, -0.5), (100, 0.5), (0, 1.5)],
                ["wall_bottom", "coping_tip", "wall_top", "coping_root"], 20, "xzy", 2.0,
                "coping_root", {"down": ("coping_tip", (0, 0, -5))})


def tee():
    return Case("tee", [(-1, 0), (1, 0), (1, 28), (20, 28), (20, 30), (-20, 30), (-20, 28), (-1, 28)],
                ["coping_web", "wall_web_r", "wall_under_r", "coping_flange_r", "wall_top",
                 "coping_flange_l", "wall_under_l", "wall_web_l"], 150, "yzx", 2.0,
                "coping_cap_0", {"down": ("coping_cap_1", (0, 0, -100)),
                                 "side": ("coping_cap_1", (0, 20, 0))})


def lbracket():
    return Case("lbracket", [(0, 0), (3, 0), (3, 57), (60, 57), (60, 60), (0, 60)],
                ["coping_foot", "wall_in_up", "wall_in_flat", "coping_tip", "wall_out_flat", "wall_out_up"],
                30, "xzy", 3.0, "coping_foot", {"down": ("coping_tip", (0, 0, -20))})


def hat(t=1.5, top=30.0, height=20.0, lip=12.0):
    h = top / 2
    section = [(-h - lip + t, 0), (-h + t, 0), (-h + t, height - t), (h - t, height - t), (h - t, 0),
               (h + lip - t, 0), (h + lip - t, t), (h, t), (h, height), (-h, height), (-h, t),
               (-h - lip + t, t)]
    sides = ["wall_lip_l_b", "wall_in_l", "wall_in_top", "wall_in_r", "wall_lip_r_b", "coping_r",
             "wall_lip_r_t", "wall_out_r", "wall_top", "wall_out_l", "wall_lip_l_t", "coping_l"]
    return Case("hat", section, sides, 150, "yzx", t, "coping_cap_0",
                {"down": ("coping_cap_1", (0, 0, -50))})


def arch(radius=40.0, t=2.0, facets=48):
    """A curved wall: half a ring, held at one foot, pulled at the other."""
    turn = [math.pi * k / facets for k in range(facets + 1)]
    # The outline of the facets is moved out so that areas are those of the circle.
    grow = math.sqrt((math.pi / facets) / math.sin(math.pi / facets))
    ring = lambda r: [(r * grow * math.cos(a), r * grow * math.sin(a)) for a in turn]
    section = ring(radius + t / 2) + ring(radius - t / 2)[::-1]
    sides = ["wall_out"] * facets + ["coping_foot"] + ["wall_in"] * facets + ["coping_tip"]
    return Case("arch", section, sides, 20, "xzy", t, "coping_foot", {"out": ("coping_tip", (5, 0, 0))})


def cross(arm=20.0, t=2.0):
    """Four sheets on one seam."""
    h = t / 2
    quarter = [(h, -arm), (h, -h), (arm, -h), (arm, h), (h, h), (h, arm), (-h, arm), (-h, h), (-arm, h),
               (-arm, -h), (-h, -h), (-h, -arm)]
    sides = ["wall_1", "wall_2", "coping_right", "wall_3", "wall_4", "coping_top", "wall_5", "wall_6",
             "coping_left", "wall_7", "wall_8", "coping_bottom"]
    return Case("cross", quarter, sides, 150, "yzx", t, "coping_cap_0",
                {"down": ("coping_cap_1", (0, 0, -60))})


CASES = {f.__name__: f for f in (plate, taper, tee, lbracket, hat, arch, cross)}

# Solid: ten-node tetrahedra; deflection in mm of each load, first frequency in Hz.
SOLID = {
    "plate": {"down": 1.16827, "f1": 169.110},
    "taper": {"down": 0.370897, "f1": 289.296},
    "tee": {"down": 0.0552146, "side": 0.0182940, "f1": 470.156},
    "lbracket": {"down": 0.359786, "f1": 248.900},
    "hat": {"down": 0.0396061, "f1": 495.846},
    "arch": {"out": 0.175150, "f1": 131.487},
    "cross": {"down": 0.0328259, "f1": 575.546},
}


# ------------------------------------------------------------------ the part as a mesh
def ear_clip(polygon):
    """Triangles of a simple polygon, corners in its order."""
    rest = list(range(len(polygon)))
    out = []

    def cross2(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    while len(rest) > 3:
        best = None
        for k in range(len(rest)):
            i, j, m = rest[k - 1], rest[k], rest[(k + 1) % len(rest)]
            a, b, c = polygon[i], polygon[j], polygon[m]
            if cross2(a, b, c) <= 1e-12:
                continue
            blocked = any(min(cross2(a, b, polygon[o]), cross2(b, c, polygon[o]), cross2(c, a, polygon[o])) >= -1e-12
                          for o in rest if o not in (i, j, m))
            if not blocked:
                size = -math.dist(a, c)
                if best is None or size > best[0]:
                    best = (size, k, (i, j, m))
        out.append(best[2])
        rest.pop(best[1])
    return out + [tuple(rest)]


def part_mesh(case, edge):
    """Points, triangles and a name for each: closed, outward, no edge much longer than ``edge``."""
    n = len(case.section)
    points = [case.xyz(u, v, w) for w in (0.0, case.length) for u, v in case.section]
    groups = {}
    for i in range(n):
        j = (i + 1) % n
        groups.setdefault(case.sides[i], []).extend([(i, j, n + j), (i, n + j, n + i)])
    for i, j, k in ear_clip(case.section):
        groups.setdefault("coping_cap_0", []).append((k, j, i))
        groups.setdefault("coping_cap_1", []).append((n + i, n + j, n + k))
    triangles = [(t, name) for name, all_ in groups.items() for t in all_]
    volume = sum(np.dot(points[a], np.cross(points[b], points[c])) for (a, b, c), _ in triangles)
    if volume < 0:
        triangles = [((a, c, b), name) for (a, b, c), name in triangles]
    return refine(points, triangles, edge)


def refine(points, triangles, edge):
    """Halves the longest side of triangles, on both sides of it, until all are short."""
    points = list(points)
    middle = {}
    while True:
        long_sides = set()
        for t, _ in triangles:
            sides = [(math.dist(points[t[k]], points[t[(k + 1) % 3]]), tuple(sorted((t[k], t[(k + 1) % 3]))))
                     for k in range(3)]
            length, side = max(sides)
            if length > edge:
                long_sides.add(side)
        if not long_sides:
            return np.array(points), triangles
        out = []
        for t, name in triangles:
            stack = [t]
            for k in range(3):
                side = tuple(sorted((t[k], t[(k + 1) % 3])))
                if side not in long_sides:
                    continue
                if side not in middle:
                    middle[side] = len(points)
                    points.append((points[side[0]] + points[side[1]]) / 2)
                m = middle[side]
                for q in list(stack):
                    if side[0] in q and side[1] in q:
                        at = next(i for i in range(3) if {q[i], q[(i + 1) % 3]} == set(side))
                        a, b, c = q[at], q[(at + 1) % 3], q[(at + 2) % 3]
                        stack.remove(q)
                        stack += [(a, m, c), (m, b, c)]
                        break
            out += [(q, name) for q in stack]
        triangles = out


def turn():
    """A rotation with no axis near the world's, and a shift."""
    a, b, c = 0.61, 0.37, 0.83
    about = lambda i, j, angle: np.array([[1.0 if r == q else 0.0 for q in range(3)] for r in range(3)]) + \
        np.array([[(math.cos(angle) - 1 if r == q and r in (i, j) else
                    -math.sin(angle) if (r, q) == (i, j) else
                    math.sin(angle) if (r, q) == (j, i) else 0.0) for q in range(3)] for r in range(3)])
    return about(0, 1, a) @ about(2, 0, b) @ about(1, 2, c), np.array([11.3, -7.1, 3.9])


def write_part(case, folder, turned=False, edge=5.0):
    """Writes NAME.obj, a group for each face, and NAME.coping.toml; the OBJ's path."""
    points, triangles = part_mesh(case, edge)
    name = case.name
    if turned:
        rotation, shift = turn()
        points = points @ rotation.T + shift
        name += "_turned"
    order = sorted({n for _, n in triangles})
    path = f"{folder}/{name}.obj"
    with open(path, "w") as out:
        for p in points:
            out.write("v {:.12g} {:.12g} {:.12g}\n".format(*p))
        for group in order:
            out.write(f"g {group}\n")
            for t, n in triangles:
                if n == group:
                    out.write("f {} {} {}\n".format(*(v + 1 for v in t)))
    with open(f"{folder}/{name}.coping.toml", "w") as out:
        out.write('format = "coping-tags"\nversion = 1\n\n[[coping]]\nname = "all"\ngroup = ["coping_*"]\n')
    return path
