#!/usr/bin/env python3
"""Solves what `midsurf extract` writes, and compares with the solid.

    solve.py [CASE ...] [--midsurf PATH] [--cells 1t] [--extract "--element-size 2t"] [--turned both]
             [--json report.json] [--keep FOLDER]

For each case: the part is written, `midsurf extract` makes an .inp of it, and CalculiX solves that deck, with
supports and loads on its node sets, for the deflection in the direction of the load and the first frequency.
Needs ccx (Debian package calculix-ccx) and numpy. Exit code 1 if a case stops or is off by more than its limit.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

from cases import CASES, SOLID, turn, write_part

# Largest accepted difference to the solid. A bend of a thin shell lacks the stiff corner block of the solid.
LIMIT = {"hat": 0.02}


def read_deck(path):
    """Nodes, elements (number, nodes), node sets and nodal thickness of a deck that midsurf wrote."""
    nodes, elements, sets, thickness = {}, [], {}, {}
    keyword, current = "", None
    for line in open(path):
        line = line.strip()
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            keyword = line.split(",")[0]
            m = re.search(r"NSET=(\w+)", line)
            current = m.group(1) if m else None
            continue
        row = [x for x in line.replace(" ", "").split(",") if x]
        if keyword == "*NODE":
            nodes[int(row[0])] = np.array([float(x) for x in row[1:4]])
        elif keyword == "*ELEMENT":
            elements.append([int(x) for x in row])
        elif keyword == "*NSET":
            sets.setdefault(current, []).extend(int(x) for x in row)
        elif keyword == "*NODAL THICKNESS":
            thickness[int(row[0])] = float(row[1])
    return nodes, elements, sets, thickness


def line_load(nodes, elements, thickness, members):
    """Share of a load at each node of a set: by length and thickness, over the element sides in it."""
    members = set(members)
    weight = {}
    for row in elements:
        con = row[1:]
        sides = {3: 3, 6: 3, 4: 4, 8: 4}[len(con)]
        for k in range(sides):
            a, b = con[k], con[(k + 1) % sides]
            m = con[sides + k] if len(con) > sides else None
            # A side with both ends in the set and its middle too lies on the border.
            if a not in members or b not in members or (m is not None and m not in members):
                continue
            w = np.linalg.norm(nodes[a] - nodes[b]) * (thickness[a] + thickness[b]) / 2
            parts = [(a, w / 2), (b, w / 2)] if m is None else [(a, w / 6), (b, w / 6), (m, w / 1.5)]
            for n, x in parts:
                weight[n] = weight.get(n, 0.0) + x
    total = sum(weight.values())
    return {n: w / total for n, w in weight.items()}


def run_ccx(folder, job, timeout):
    ccx = os.environ.get("CCX") or shutil.which("ccx")
    if not ccx:
        sys.exit("ccx (CalculiX) is not on the path; set CCX to it")
    start = time.time()
    with open(f"{folder}/{job}.log", "w") as log:
        try:
            subprocess.run([ccx, "-i", job], cwd=folder, stdout=log, stderr=log, timeout=timeout,
                           env=dict(os.environ, OMP_NUM_THREADS="1"))
        except subprocess.TimeoutExpired:
            return ["timeout"], timeout
    text = open(f"{folder}/{job}.log", errors="replace").read()
    return [line.strip() for line in text.splitlines() if "*ERROR" in line], time.time() - start


def read_results(path, loads):
    """Displacements of each load's set, and the frequencies."""
    blocks, frequencies, mode = [], [], None
    if not os.path.exists(path):
        return blocks, frequencies
    for line in open(path, errors="replace"):
        low = line.lower()
        if "displacements" in low:
            blocks.append({})
            mode = "u"
        elif "e i g e n v a l u e" in low:
            mode = "f"
        elif "p a r t i c i p a t i o n" in low or "e f f e c t i v e" in low:
            mode = None
        else:
            row = line.split()
            if mode == "u" and len(row) == 4 and row[0].isdigit():
                blocks[-1][int(row[0])] = np.array([float(x) for x in row[1:]])
            elif mode == "f" and len(row) >= 4 and row[0].isdigit():
                frequencies.append(float(row[3]))
    return blocks[:loads], frequencies


def set_of(face):
    return "COPING_" + face.upper().removeprefix("COPING_")


def draw(path, nodes, elements, moved, largest=0.15):
    """The deformed shell, coloured by deflection; largest: share of the box's diagonal that it is drawn with."""
    import pyvista
    number = {n: i for i, n in enumerate(nodes)}
    points = np.array(list(nodes.values()))
    shift = np.array([moved.get(n, np.zeros(3)) for n in nodes])
    size = np.linalg.norm(shift, axis=1)
    scale = largest * np.linalg.norm(np.ptp(points, axis=0)) / size.max()
    faces = []
    for _, *con in elements:
        sides = 3 if len(con) in (3, 6) else 4
        faces += [sides] + [number[n] for n in con[:sides]]
    mesh = pyvista.PolyData(points + scale * shift, faces)
    mesh["deflection, mm"] = size
    plotter = pyvista.Plotter(off_screen=True, window_size=(1400, 800))
    plotter.add_mesh(mesh, scalars="deflection, mm", show_edges=True, line_width=0.5, cmap="viridis")
    plotter.add_mesh(pyvista.PolyData(points, faces), style="wireframe", color="grey", opacity=0.15)
    plotter.camera_position = "iso"
    plotter.screenshot(path)


def solve(case, deck, folder, rotation, timeout, picture=None):
    """Figures of one deck: deflection by load, first frequency, or what went wrong."""
    nodes, elements, sets, thickness = read_deck(deck)
    job = "solve"
    # The deck as written, then supports and steps.
    text = open(deck).read()
    with open(f"{folder}/{job}.inp", "w") as out:
        out.write(text)
        out.write(f"*BOUNDARY\n{set_of(case.clamp)}, 1, 6\n")
        forces = []
        for face, force in case.loads.values():
            share = line_load(nodes, elements, thickness, sets[set_of(face)])
            force = rotation @ np.array(force, float)
            forces.append({n: force * s for n, s in share.items()})
            out.write("*STEP\n*STATIC\n*CLOAD, OP=NEW\n")
            for n, f in forces[-1].items():
                for k in range(3):
                    out.write(f"{n}, {k + 1}, {f[k]:.12e}\n")
            out.write(f"*NODE PRINT, NSET={'NALL' if picture else set_of(face)}\nU\n*END STEP\n")
        out.write("*STEP\n*FREQUENCY\n2\n*END STEP\n")
    errors, seconds = run_ccx(folder, job, timeout)
    blocks, frequencies = read_results(f"{folder}/{job}.dat", len(forces))
    result = {"elements": len(elements), "seconds": round(seconds, 1), "errors": errors[:3], "n_errors": len(errors)}
    for (name, _), force, moved in zip(case.loads.items(), forces, blocks):
        total = np.linalg.norm(sum(force.values()))
        if all(n in moved for n in force):
            result[name] = float(sum(f @ moved[n] for n, f in force.items()) / total)
    if frequencies:
        result["f1"] = frequencies[0]
    if picture and blocks:
        draw(picture, nodes, elements, blocks[0])
    return result


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("cases", nargs="*", default=list(SOLID), help="default: all")
    ap.add_argument("--midsurf", default=shutil.which("midsurf") or "target/release/midsurf")
    ap.add_argument("--cells", default="1t", help="cell size (default: one thickness)")
    ap.add_argument("--extract", default="", help="further options of midsurf extract, in one string")
    ap.add_argument("--turned", choices=["no", "yes", "both"], default="both")
    ap.add_argument("--json")
    ap.add_argument("--keep", help="keep all files in this folder")
    ap.add_argument("--picture", help="draw the deformed shell of the last case here (.png; needs pyvista)")
    ap.add_argument("--timeout", type=float, default=900)
    a = ap.parse_args()
    work = a.keep or tempfile.mkdtemp(prefix="midsurf_cae_")
    os.makedirs(work, exist_ok=True)
    report, bad = [], 0
    print(f"{'case':18} {'elements':>8} {'leaning':>7} {'load':>6} {'shell':>10} {'solid':>10} {'off %':>7}   s")
    for name in a.cases:
        case = CASES[name]()
        for turned in {"no": [False], "yes": [True], "both": [False, True]}[a.turned]:
            label = name + ("_turned" if turned else "")
            folder = f"{work}/{label}"
            os.makedirs(folder, exist_ok=True)
            part = write_part(case, folder, turned)
            command = [a.midsurf, "extract", part, "--coping", part.replace(".obj", ".coping.toml"), "--cell", a.cells,
                       "-q", "-o", f"{folder}/model.inp", "--json", f"{folder}/extract.json", *a.extract.split()]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode == 1:
                print(f"{label:18} the mid-surface has cracks")
            elif done.returncode:
                print(f"{label:18} extract: {done.stderr.strip()}")
                bad += 1
                continue
            model = json.load(open(f"{folder}/extract.json"))["shell"]
            rotation = turn()[0] if turned else np.eye(3)
            r = solve(case, f"{folder}/model.inp", folder, rotation, a.timeout, a.picture)
            r.update(case=label, leaning=model["leaning_elements"])
            report.append(r)
            for figure, solid in SOLID.get(name, {}).items():
                off = r[figure] / solid - 1 if figure in r else None
                r[f"{figure}_off"] = off
                bad += off is None or abs(off) > LIMIT.get(name, 0.01)
                shown = "stops" if off is None else f"{100 * off:+.2f}"
                print(f"{label:18} {r['elements']:8} {r['leaning']:7} {figure:>6} {r.get(figure, float('nan')):10.5g} "
                      f"{solid:10.5g} {shown:>7}   {r['seconds']}", flush=True)
            if r["n_errors"]:
                print(f"{'':18} {r['n_errors']} errors: {r['errors'][0]}")
    if a.json:
        json.dump(report, open(a.json, "w"), indent=1)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
