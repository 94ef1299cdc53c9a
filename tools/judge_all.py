#!/usr/bin/env python3
"""Extracts every part of a folder at several cell sizes, has each result judged
by an external program, and prints one Markdown table.

    judge_all.py PARTS JUDGE.py [--binary target/release/midsurf] [--jobs 2]

A part is NAME.obj with NAME.coping.txt beside it, and NAME.truth.json if there
is one. The judge is called as `JUDGE.py PART.obj TAGS.txt MID.obj --truth T.json
--cell H --json OUT.json`. Figures beyond the limits below are set in bold; the
exit status is 1 if there are any. Cells are in median wall thicknesses.
"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys
import tempfile
import time

# Largest good value of each column; counts are compared with the truth.
LIMITS = {
    "exit": 0, "cracks": 0, "judge cracks": 0, "bad faces": 0, "residual p99": 1e-6, "coping gap": 1e-6,
    "seam error": 1e-6, "self-int.": 0, "outside": 0, "thickness p99": 1e-6,
}
# Distance to the exact medial surface, in wall thicknesses, at cells up to FINE.
TRUTH_LIMIT, FINE = 0.03, 0.34
COLUMNS = [
    "part", "cell", "exit", "cracks", "judge cracks", "bad faces", "counts", "truth", "residual p99",
    "truth to mid", "mid to truth", "coping gap", "seam error", "self-int.", "outside", "thickness p99",
    "closed over", "triangles", "seconds", "judge s",
]


def get(tree, path):
    """Value at a dotted path, or None."""
    for key in path.split("."):
        tree = tree.get(key) if isinstance(tree, dict) else None
    return tree


def total(tree, *paths):
    values = [get(tree, path) for path in paths]
    return None if None in values else sum(values)


def counts(*values):
    return " / ".join("-" if v is None else str(v) for v in values)


def load(path):
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def measure(part, factor, options, folder):
    """One row of the table, as a dictionary by column."""
    stem = part.stem
    tags, truth_file = part.with_name(stem + ".coping.txt"), part.with_name(stem + ".truth.json")
    mid = folder / f"{stem}.{factor:g}.obj"
    report_file, judged_file = mid.with_suffix(".report.json"), mid.with_suffix(".judge.json")
    row = {"part": stem, "cell": f"{factor:.3g} t"}
    command = [options.binary, "extract", part, "--coping", tags, "--cell", f"{factor}t", "-o", mid, "--json",
               report_file, "--quiet", "--threads", options.threads]
    start = time.monotonic()
    try:
        done = subprocess.run([str(w) for w in command], capture_output=True, text=True, timeout=options.timeout)
    except subprocess.TimeoutExpired:
        return row | {"exit": "timeout"}
    row["seconds"] = time.monotonic() - start
    row["exit"] = done.returncode
    if done.returncode not in (0, 1):
        row["note"] = " ".join(done.stderr.split())[-300:]
        return row
    report, truth = load(report_file), load(truth_file)
    row["cracks"] = report.get("cracks")
    row["closed over"] = len(report.get("closed_over", []))
    row["triangles"] = get(report, "result.counts.triangles")

    command = [sys.executable, options.judge, part, tags, mid, "--json", judged_file, "--cell",
               get(report, "settings.cell_length")]
    if truth_file.exists():
        command += ["--truth", truth_file]
    start = time.monotonic()
    try:
        done = subprocess.run([str(w) for w in command], capture_output=True, text=True, timeout=options.timeout)
    except subprocess.TimeoutExpired:
        return row | {"judge s": "timeout"}
    row["judge s"] = time.monotonic() - start
    judged = load(judged_file)
    if not judged:
        row["note"] = "judge: " + " ".join(done.stderr.split())[-300:]
        return row
    ideal = truth.get("ideal_mid") or {}
    row["counts"] = counts(get(judged, "topology.sheets"), get(judged, "topology.seams.polylines"),
                           get(judged, "topology.components"), get(report, "result.counts.euler"))
    if ideal:
        row["truth"] = counts(*(ideal.get(k) for k in ("sheets", "seams", "components", "euler")))
    row["judge cracks"] = get(judged, "topology.boundary.crack_edges")
    row["bad faces"] = total(judged, "topology.dup_faces", "topology.degenerate_faces")
    row["residual p99"] = get(judged, "residual.vertex.rel_p99")
    row["truth to mid"] = get(judged, "truth2d.core.truth_to_mid.max_over_t")
    row["mid to truth"] = get(judged, "truth2d.core.mid_to_truth.max_over_t")
    row["coping gap"] = get(judged, "topology.boundary.coping_gap_max_over_t")
    row["seam error"] = get(judged, "truth2d.core.seam.mid_to_truth_max_over_t")
    pairs = "geometry.self_intersections."
    row["self-int."] = total(judged, pairs + "crossing", pairs + "contact", pairs + "coplanar_overlap")
    row["outside"] = get(judged, "geometry.inside.vertices_outside")
    row["thickness p99"] = get(judged, "geometry.thickness_vs_chord.rel_p99")
    return row


def falls_short(row, column, factor):
    value = row.get(column)
    if column == "exit" and isinstance(value, str):
        return True
    if column == "counts":
        return bool(row.get("truth")) and value != row["truth"]
    if not isinstance(value, (int, float)):
        return False
    if column in ("truth to mid", "mid to truth"):
        return factor <= FINE and value > TRUTH_LIMIT
    return column in LIMITS and value > LIMITS[column]


def show(value):
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.2g}"
    return str(value)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", type=pathlib.Path, help="folder of parts")
    parser.add_argument("judge", type=pathlib.Path, help="judge script (Python)")
    parser.add_argument("--binary", type=pathlib.Path, default=pathlib.Path("target/release/midsurf"))
    parser.add_argument("--jobs", type=int, default=1, help="parts at a time")
    parser.add_argument("--threads", type=int, default=2, help="threads of each extraction")
    parser.add_argument("--cells", default="0.333333,1,3", help="in median wall thicknesses, with commas between")
    parser.add_argument("--only", help="names of parts with commas between")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for one extraction or judgement")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the results (default: thrown away)")
    options = parser.parse_args()
    only = options.only.split(",") if options.only else None
    parts = [p for p in sorted(options.parts.glob("*.obj")) if p.with_name(p.stem + ".coping.txt").exists()]
    parts = [p for p in parts if only is None or p.stem in only]
    if not parts:
        parser.error(f"no part with tags in {options.parts}")
    factors = [float(f) for f in options.cells.split(",")]
    short = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print("| " + " | ".join(COLUMNS) + " |")
        print("|" + " --- |" * len(COLUMNS), flush=True)
        notes = []
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            jobs = [(pool.submit(measure, part, f, options, folder), f) for part in parts for f in factors]
            for job, factor in jobs:
                row = job.result()
                cells = []
                for column in COLUMNS:
                    bad = falls_short(row, column, factor)
                    short += bad
                    cells.append(f"**{show(row.get(column))}**" if bad else show(row.get(column)))
                print("| " + " | ".join(cells) + " |", flush=True)
                if "note" in row:
                    notes.append(f"- {row['part']}, cell {row['cell']}: {row['note']}")
    print("\nCounts are sheets / seams / components / Euler characteristic. Lengths are in wall thicknesses; the")
    print("residual and the thickness error are relative. Closed over: coping faces that got no border.")
    if notes:
        print("\n" + "\n".join(notes))
    print(f"\n{short} figures fall short.")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
