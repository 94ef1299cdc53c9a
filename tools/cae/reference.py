#!/usr/bin/env python3
"""Solves the solid of a case: ten-node tetrahedra by gmsh, static steps and frequencies by CalculiX.

    reference.py CASE [--size 0.75] [--keep FOLDER]

Prints the figures that stand in `cases.SOLID`. Solve with two sizes to see how far they still move.
"""
import argparse
import os
import tempfile

import numpy as np

from cases import CASES, DENSITY, E_MODULUS, POISSON
from solve import read_results, run_ccx


def mesh(case, size):
    """Nodes by number, tetrahedra in CalculiX's order, and the quadratic triangles of each named side."""
    import gmsh
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    points = [occ.addPoint(*case.xyz(u, v, 0.0)) for u, v in case.section]
    lines = [occ.addLine(points[i], points[(i + 1) % len(points)]) for i in range(len(points))]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    swept = occ.extrude([(2, face)], *case.xyz(0.0, 0.0, case.length))
    occ.synchronize()
    sides = {"coping_cap_0": [face], "coping_cap_1": [swept[0][1]]}
    for name, (_, surface) in zip(case.sides, swept[2:]):
        sides.setdefault(name, []).append(surface)
    for option, value in {"MeshSizeMin": size, "MeshSizeMax": size, "ElementOrder": 2, "HighOrderOptimize": 0}.items():
        gmsh.option.setNumber(f"Mesh.{option}", value)
    gmsh.model.mesh.generate(3)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    nodes = dict(zip((int(t) for t in tags), xyz.reshape(-1, 3)))
    tets = gmsh.model.mesh.getElementsByType(11)[1].reshape(-1, 10).astype(int)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
    triangles = {name: np.concatenate([gmsh.model.mesh.getElementsByType(9, s)[1].reshape(-1, 6).astype(int) for s in all_])
                 for name, all_ in sides.items()}
    gmsh.finalize()
    return nodes, tets, triangles


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("case", choices=sorted(CASES))
    ap.add_argument("--size", type=float, default=0.75, help="element size in thicknesses")
    ap.add_argument("--keep")
    ap.add_argument("--timeout", type=float, default=3600)
    a = ap.parse_args()
    case = CASES[a.case]()
    folder = a.keep or tempfile.mkdtemp(prefix="midsurf_solid_")
    os.makedirs(folder, exist_ok=True)
    nodes, tets, triangles = mesh(case, a.size * case.thickness)
    forces = []
    for face, force in case.loads.values():
        share = {}
        for t in triangles[face]:
            p = [nodes[n] for n in t[:3]]
            area = np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0])) / 2
            # A constant pressure on a quadratic triangle goes to the middles of its sides.
            for n in t[3:]:
                share[n] = share.get(n, 0.0) + area / 3
        total = sum(share.values())
        forces.append({n: np.array(force, float) * s / total for n, s in share.items()})
    with open(f"{folder}/solid.inp", "w") as out:
        out.write("*NODE, NSET=NALL\n")
        for n, p in nodes.items():
            out.write("{}, {:.12g}, {:.12g}, {:.12g}\n".format(n, *p))
        out.write("*ELEMENT, TYPE=C3D10, ELSET=EALL\n")
        for e, t in enumerate(tets, 1):
            out.write(f"{e}, " + ", ".join(map(str, t)) + "\n")
        out.write("*NSET, NSET=HELD\n" + "".join(f"{n},\n" for n in sorted(set(triangles[case.clamp].ravel()))))
        for k, force in enumerate(forces):
            out.write(f"*NSET, NSET=LOADED{k}\n" + "".join(f"{n},\n" for n in sorted(force)))
        out.write(f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{E_MODULUS}, {POISSON}\n*DENSITY\n{DENSITY}\n"
                  "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL\n*BOUNDARY\nHELD, 1, 3\n")
        for k, force in enumerate(forces):
            out.write("*STEP\n*STATIC\n*CLOAD, OP=NEW\n")
            for n, f in force.items():
                out.write("".join(f"{n}, {i + 1}, {f[i]:.12e}\n" for i in range(3) if f[i]))
            out.write(f"*NODE PRINT, NSET=LOADED{k}\nU\n*END STEP\n")
        out.write("*STEP\n*FREQUENCY\n2\n*END STEP\n")
    errors, seconds = run_ccx(folder, "solid", a.timeout)
    blocks, frequencies = read_results(f"{folder}/solid.dat", len(forces))
    figures = {name: float(sum(f @ moved[n] for n, f in force.items()) / np.linalg.norm(sum(force.values())))
               for name, force, moved in zip(case.loads, forces, blocks)}
    print(case.name, {**figures, "f1": frequencies[0] if frequencies else None},
          f"{len(nodes)} nodes, {seconds:.0f} s", *errors[:1])


if __name__ == "__main__":
    main()
