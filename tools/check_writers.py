#!/usr/bin/env python3
"""Reads back what `midsurf extract` writes for solvers, with programs of others.

    check_writers.py [--midsurf PATH] [--part fixtures/tee.obj --coping fixtures/tee.coping.txt]

The .inp is read by meshio, the .bdf by pyNastran, the .msh by gmsh and meshio, the .glb by trimesh if it is there;
nodes, elements, sets, thickness and area must be those of the report and agree among all. Needs numpy, meshio, gmsh
and pyNastran (pip install numpy meshio gmsh pyNastran trimesh). Exit code 1 and a line for what differs.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

FAILED = []


def expect(what, found, wanted):
    same = np.allclose(found, wanted, rtol=1e-5) if isinstance(wanted, float) else found == wanted
    print(f"  {'ok' if same else 'DIFFERS':8} {what}: {found}" + ("" if same else f", not {wanted}"))
    if not same:
        FAILED.append(what)


def area(points, corners):
    """Area of triangles and quads, by their corners."""
    total = 0.0
    for c in corners:
        p = points[c]
        for k in range(1, len(c) - 1):
            total += 0.5 * np.linalg.norm(np.cross(p[k] - p[0], p[k + 1] - p[0]))
    return float(total)


def by_meshio(file, truth, order):
    import meshio
    mesh = meshio.read(file)
    cells = [b for b in mesh.cells if b.type.startswith(("triangle", "quad"))]
    print(f"meshio {meshio.__version__} reads {os.path.basename(file)}")
    expect("nodes", len(mesh.points), truth["nodes"])
    expect("elements", sum(len(b.data) for b in cells), truth["elements"])
    corners = [c[:3 if b.type.startswith("triangle") else 4] for b in cells for c in b.data]
    expect("area", area(mesh.points, corners), truth["area"])
    if file.endswith(".inp"):
        for s in truth["sets"]:
            expect(s["name"], len(mesh.point_sets[s["name"]]), s["nodes"])
    else:
        t = mesh.point_data["thickness"]
        expect("thickness", [round(float(x), 6) for x in (t.min(), t.max())], truth["thickness"])


def by_gmsh(file, truth):
    import gmsh
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(file)
    print(f"gmsh {gmsh.option.getString('General.Version')} reads {os.path.basename(file)}")
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    points = dict(zip(tags, xyz.reshape(-1, 3)))
    expect("nodes", len(tags), truth["nodes"])
    corners, count = [], 0
    for _, entity in gmsh.model.getEntities(2):
        for kind, _, nodes in zip(*gmsh.model.mesh.getElements(2, entity)):
            per = gmsh.model.mesh.getElementProperties(kind)
            rows = nodes.reshape(-1, per[3])
            count += len(rows)
            corners += [r[:per[5]] for r in rows]
    expect("elements", count, truth["elements"])
    number = {t: i for i, t in enumerate(points)}
    corners = [np.array([number[n] for n in c]) for c in corners]
    expect("area", area(np.array(list(points.values())), corners), truth["area"])
    for s in truth["sets"]:
        group = next((t for d, t in gmsh.model.getPhysicalGroups(1) if gmsh.model.getPhysicalName(d, t) == s["name"]), None)
        nodes = set()
        for entity in gmsh.model.getEntitiesForPhysicalGroup(1, group) if group else []:
            nodes.update(gmsh.model.mesh.getElements(1, entity)[2][0])
        expect(s["name"], len(nodes), s["nodes"])
    names = [gmsh.model.getPhysicalName(d, t) for d, t in gmsh.model.getPhysicalGroups(2)]
    expect("sheets", names, [f"SHEET_{n + 1}" for n in range(truth["sheets"])])
    gmsh.finalize()


def by_pynastran(file, truth):
    import pyNastran
    from pyNastran.bdf.bdf import read_bdf
    bdf = read_bdf(file, xref=True, debug=False)
    print(f"pyNastran {pyNastran.__version__} reads {os.path.basename(file)}")
    expect("nodes", len(bdf.nodes), truth["nodes"])
    expect("elements", len(bdf.elements), truth["elements"])
    expect("area", float(sum(e.Area() for e in bdf.elements.values())), truth["area"])
    t = [x for e in bdf.elements.values() for x in (e.T1, e.T2, e.T3)]
    expect("thickness", [round(min(t), 3), round(max(t), 3)], [round(x, 3) for x in truth["corner_thickness"]])
    expect("properties", sorted(bdf.properties), list(range(1, truth["sheets"] + 1)))
    expect("bending and shear", {(p.mid2, p.mid3) for p in bdf.properties.values()}, {(1, 1)})
    expect("sets", [len(bdf.sets[n + 1].ids) for n in range(len(truth["sets"]))], [s["nodes"] for s in truth["sets"]])


def by_trimesh(file, truth):
    try:
        import trimesh
    except ImportError:
        return print("trimesh is not there: the .glb is not read")
    scene = trimesh.load(file)
    print(f"trimesh {trimesh.__version__} reads {os.path.basename(file)}")
    sheets = [g for g in scene.geometry.values() if hasattr(g, "faces")]
    expect("sheets", len(sheets), truth["sheets"])
    expect("area", float(sum(g.area for g in sheets)), truth["area"])
    low, high = scene.bounds
    expect("box", bool(np.allclose([low, high], truth["box"], atol=1e-4)), True)


def main():
    here = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--midsurf", default=shutil.which("midsurf") or f"{here}/target/release/midsurf")
    ap.add_argument("--part", default=f"{here}/fixtures/tee.obj")
    ap.add_argument("--coping", default=f"{here}/fixtures/tee.coping.txt")
    ap.add_argument("--extract", default="", help="further options of midsurf extract, in one string")
    a = ap.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for order in (1, 2):
            names = [f"{folder}/model{order}.{s}" for s in ("inp", "bdf", "msh", "glb")]
            # The dialect whose element names meshio knows.
            command = [a.midsurf, "extract", a.part, "--coping", a.coping, "--order", str(order), "--dialect", "abaqus",
                       "-q", "--json", f"{folder}/report.json", *a.extract.split()]
            for n in names:
                command += ["-o", n]
            subprocess.run(command, check=True)
            report = json.load(open(f"{folder}/report.json"))
            shell = report["shell"]
            import meshio
            mesh = meshio.read(names[2])
            t = mesh.point_data["thickness"]
            corners = sorted({n for b in mesh.cells if b.type.startswith(("tri", "quad"))
                              for c in b.data for n in c[:3 if b.type.startswith("tri") else 4]})
            truth = {"nodes": shell["nodes"], "elements": shell["elements"], "sets": shell["sets"],
                     "sheets": len(shell["sheets"]), "area": report["result"]["area"],
                     "thickness": [round(float(x), 6) for x in (t.min(), t.max())],
                     "corner_thickness": [float(t[corners].min()), float(t[corners].max())],
                     "box": [mesh.points.min(0), mesh.points.max(0)]}
            print(f"order {order}")
            by_meshio(names[0], truth, order)
            by_meshio(names[2], truth, order)
            by_gmsh(names[2], truth)
            by_pynastran(names[1], truth)
            by_trimesh(names[3], truth)
    if FAILED:
        print(f"{len(FAILED)} differ")
    return 1 if FAILED else 0


if __name__ == "__main__":
    sys.exit(main())
