#!/usr/bin/env python3
"""Remeshes every part of a folder at several element sizes and prints one Markdown table of what came of it.

    elements.py PARTS [--binary target/release/midsurf] [--sizes 1t,2t,5t] [--modes tri,quads] [--junctions medial]

A part is NAME.obj with NAME.coping.txt beside it. Each is traced as it is and remeshed by `midsurf extract`, the elements
read from the .inp, crossings counted by `midsurf check`. Figures beyond LIMITS are set in bold; the exit status is 1 if
there are any. Triangles of a quadrilateral are those that the surface has, cut along the better diagonal.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

# What each column must keep to; `low` counts triangles lower than a tenth of the median thickness.
LIMITS = {
    "exit": lambda x: x == 0, "cracks": lambda x: x == 0, "topology": lambda x: x == "same", "crossings": lambda x: x == 0,
    "least": lambda x: x >= 15, "1 %": lambda x: x >= 25, "low": lambda x: x == 0, "quads %": lambda x: x >= 85,
    "Jac. least": lambda x: True, "Jac. 1 %": lambda x: x >= 0.5, "warp": lambda x: x <= 10,
}
KEYS = ["sheets", "seams", "closed_seams", "junctions", "coping_borders", "fading_borders", "creases", "components", "euler"]
COLUMNS = ["part", "size", "mode", "exit", "cracks", "topology", "crossings", "elements", "least", "1 %", "low", "quads %",
           "Jac. least", "Jac. 1 %", "Jac. median", "warp", "trace s", "remesh s", "whole s"]


def read_inp(file):
    """Points and elements by their corners, from what midsurf writes."""
    points, elements, at = [], [], ""
    for line in file.read_text().splitlines():
        if line.startswith("*"):
            at = line.upper()
        elif at.startswith("*NODE,"):
            points.append([float(x) for x in line.split(",")[1:]])
        elif at.startswith("*ELEMENT"):
            elements.append([int(x) - 1 for x in line.split(",")[1:]])
    return np.array(points), elements


def angles(p):
    """Smallest angles and heights of triangles, degrees; `p` is n x 3 x 3."""
    sides = np.linalg.norm(p[:, [1, 2, 0]] - p, axis=2)
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    longest = sides.max(axis=1)
    middle = np.median(sides, axis=1)
    sine = np.clip(2 * area / (longest * middle), 0, 1)
    return np.degrees(np.arcsin(sine)), 2 * area / longest


def quad_shapes(p):
    """Scaled Jacobian and warp, degrees; `p` is n x 4 x 3."""
    normal = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    least = np.ones(len(p))
    for k in range(4):
        a, b = p[:, (k + 1) % 4] - p[:, k], p[:, (k + 3) % 4] - p[:, k]
        s = np.einsum("ij,ij->i", np.cross(a, b), normal) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
        least = np.minimum(least, s)
    worst = np.zeros(len(p))
    for k in (0, 1):
        q = np.roll(p, -k, axis=1)
        one = np.cross(q[:, 1] - q[:, 0], q[:, 2] - q[:, 0])
        two = np.cross(q[:, 2] - q[:, 0], q[:, 3] - q[:, 0])
        c = np.einsum("ij,ij->i", one, two) / (np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1))
        worst = np.maximum(worst, np.degrees(np.arccos(np.clip(c, -1, 1))))
    return least, worst


def halves(p):
    """Two triangles of each quadrilateral, cut so that the smaller angle is the larger."""
    cuts = [np.concatenate([p[:, [0, 1, 2]], p[:, [0, 2, 3]]]), np.concatenate([p[:, [1, 2, 3]], p[:, [1, 3, 0]]])]
    n = len(p)
    worst = [np.minimum(a[:n], a[n:]) for a in (angles(c)[0] for c in cuts)]
    second = worst[1] > worst[0]
    pick = np.concatenate([second, second])
    return np.where(pick[:, None, None], cuts[1], cuts[0])


def run(command):
    return subprocess.run(command, capture_output=True, text=True)


def traced(binary, part, threads):
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder, "r.json")
        coping = part.with_suffix(".coping.txt")
        done = run([binary, "extract", part, "--coping", coping, "-o", f"{folder}/m.ply", "--json", report, "--threads", threads])
        return json.loads(report.read_text())["result"] if done.returncode == 0 else None


def measure(binary, part, size, mode, junctions, threads, truth, keep):
    row = {"part": part.stem, "size": size, "mode": mode}
    with tempfile.TemporaryDirectory() as folder:
        report, inp = pathlib.Path(folder, "r.json"), pathlib.Path(folder, "m.inp")
        coping = part.with_suffix(".coping.txt")
        command = [binary, "extract", part, "--coping", coping, "--element-size", size, "--junctions", junctions, "--order", "1",
                   "-o", f"{folder}/m.ply", "-o", inp, "--json", report, "--threads", threads]
        done = run(command + (["--quads"] if mode == "quads" else []))
        row["exit"] = done.returncode
        if done.returncode not in (0, 2) or not inp.exists():
            row["why"] = done.stderr.strip().splitlines()[-1:]
            return row
        told = json.loads(report.read_text())
        result = told["result"]
        row["cracks"] = told["cracks"]
        differs = [k for k in KEYS if truth and result["counts"].get(k) != truth["counts"].get(k)]
        row["topology"] = "same" if not differs else " ".join(
            f"{k} {truth['counts'].get(k)} {result['counts'].get(k)}" for k in differs)
        checked = pathlib.Path(folder, "c.json")
        run([binary, "check", part, f"{folder}/m.ply", "--coping", coping, "--json", checked, "--threads", threads])
        row["crossings"] = crossings(checked)
        points, elements = read_inp(inp)
        quads = np.array([e for e in elements if len(e) == 4], int).reshape(-1, 4)
        lone = np.array([e for e in elements if len(e) == 3], int).reshape(-1, 3)
        triangles = np.concatenate([points[lone], halves(points[quads])]) if len(quads) else points[lone]
        angle, height = angles(triangles)
        row["elements"] = len(elements)
        row["least"], row["1 %"] = angle.min(), np.percentile(angle, 1)
        row["low"] = int((height < 0.1 * result["thickness"]["p50"]).sum())
        if mode == "quads":
            row["quads %"] = 100 * len(quads) / len(elements)
            jacobian, warp = quad_shapes(points[quads])
            row["Jac. least"], row["Jac. 1 %"], row["Jac. median"] = jacobian.min(), np.percentile(jacobian, 1), np.median(jacobian)
            row["warp"] = warp.max()
        seconds = told["seconds"]
        row["trace s"], row["remesh s"], row["whole s"] = seconds["trace"] + seconds["mesh"], seconds["remesh"], seconds["total"]
        if keep:
            inp.rename(pathlib.Path(keep, f"{part.stem}.{size}.{mode}.{junctions}.inp"))
            pathlib.Path(folder, "m.ply").rename(pathlib.Path(keep, f"{part.stem}.{size}.{mode}.{junctions}.ply"))
    return row


def crossings(report):
    """Pairs of triangles that cut each other, as `midsurf check` counts them."""
    measures = json.loads(report.read_text())["measures"] if report.exists() else []
    return next((m["count"] for m in measures if m["measure"] == "crossings"), "?")


def cell(column, row):
    value = row.get(column, "")
    if column in ("exit",) and value != 0:
        return f"**{value}** {row.get('why', '')}"
    text = f"{value:.2f}" if isinstance(value, float) else str(value)
    good = column not in LIMITS or value == "" or LIMITS[column](round(value, 2) if isinstance(value, float) else value)
    return text if good else f"**{text}**"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", type=pathlib.Path)
    parser.add_argument("--binary", default="target/release/midsurf")
    parser.add_argument("--sizes", default="1t,2t,5t")
    parser.add_argument("--modes", default="tri,quads")
    parser.add_argument("--junctions", default="medial")
    parser.add_argument("--threads", default="1")
    parser.add_argument("--only", default="", help="parts by name, with commas between")
    parser.add_argument("--keep", help="folder for the meshes")
    given = parser.parse_args()
    only = [name for name in given.only.split(",") if name]
    parts = [p for p in sorted(given.parts.glob("*.obj")) if p.with_suffix(".coping.txt").exists()]
    parts = [p for p in parts if not only or p.stem in only]
    if given.keep:
        pathlib.Path(given.keep).mkdir(parents=True, exist_ok=True)
    print("| " + " | ".join(COLUMNS) + " |\n" + "| --- " * len(COLUMNS) + "|")
    bad = 0
    for part in parts:
        truth = traced(given.binary, part, given.threads)
        for size in given.sizes.split(","):
            for mode in given.modes.split(","):
                row = measure(given.binary, part, size, mode, given.junctions, given.threads, truth, given.keep)
                line = "| " + " | ".join(cell(c, row) for c in COLUMNS) + " |"
                bad += "**" in line
                print(line, flush=True)
    print(f"\n{bad} rows with figures beyond the limits")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
