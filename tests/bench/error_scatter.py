#!/usr/bin/env python3
"""Standard errors against the scatter over seeds: one small scene per kind of unknown, fitted many times.

error_scatter.py --pathfit BUILD/app/pathfit [--repeats N] [--jobs N] [--only CASE ...]
                 [--noise-levels X ...] [--size PIXELS] [--keep DIR] [--out FILE.json]

Photos are one rendering of the truth with other noise each time, and each fit renders with a seed of its own; all else is
the default. Of each scalar: the scatter of the values found over the median of the standard errors reported (above 1: they
claim too much), the rms distance to the truth in standard errors, and the share of fits within 1 and 3 of them; without the
fits that call it not determined. The scatter of N fits is itself known to a share 1 / sqrt(2 (N - 1)).
"""
import argparse
import concurrent.futures
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from fit_runs import look_at, product, read_scalars, rotation_matrix, synth, write_transforms

FOV_DEG = 40.0
PHOTO_SPP = 16384
MEAN = 0.3  # of these pictures, about
LIMIT = 1.3

# Of each case: what is free with its start, and its truth. The camera begins turned and shifted by POSE.
POSE = ([0.02, -0.015, 0.01], [0.05, -0.04, 0.06])
CASES = {
    "colours": ({"ball_paint.base_color": [0.5, 0.5, 0.5], "floor_paint.base_color": [0.5, 0.5, 0.5]},
                {"ball_paint.base_color": [0.7, 0.3, 0.15], "floor_paint.base_color": [0.3, 0.45, 0.6]}),
    "lights": ({"key.intensity": [5.0, 5.0, 5.0], "fill.intensity": [0.4, 0.4, 0.4]},
               {"key.intensity": [9.0, 8.0, 6.0], "fill.intensity": [0.15, 0.2, 0.25]}),
    "gloss": ({"ball_paint.roughness": [0.5], "ball_paint.metallic": [0.5]}, {"ball_paint.roughness": [0.35], "ball_paint.metallic": [0.8]}),
    "camera": ({"view.exr.position": None, "view.exr.rotation": None}, {"view.exr.position": [0.0, 1.8, 3.2], "view.exr.rotation": [-x for x in POSE[0]]}),
    "exposure": ({"floor_paint.base_color": [0.5, 0.5, 0.5], "view.exr.exposure": [1.0]},
                 {"floor_paint.base_color": [0.3, 0.45, 0.6], "view.exr.exposure": [1.3]}),
    "place": ({"block.translation": [0.0] * 3, "block.scale": [1.0]}, {"block.translation": [0.08, 0.05, -0.06], "block.scale": [1.08]}),
}


def scene(values, glossy):
    def of(name, default):
        return values.get(name, default)
    ball = {"model": "diffuse", "base_color": {"constant": of("ball_paint.base_color", [0.6, 0.5, 0.4])}}
    if glossy:
        ball.update(model="metallic_roughness", roughness={"constant": of("ball_paint.roughness", [0.4])[0]},
                    metallic={"constant": of("ball_paint.metallic", [0.5])[0]})
    size, shift = 0.35 * of("block.scale", [1.0])[0], of("block.translation", [0.0] * 3)
    place = [0.6 + shift[0], 0.7 + shift[1], 0.2 + shift[2]]
    return {
        "geometry": {
            "floor": {"primitive": {"rectangle": {}}, "material": "floor_paint", "normals": "flat",
                      "transform": {"scale": 2.5, "rotate": {"axis": [1, 0, 0], "angle_deg": -90}}},
            "ball": {"primitive": {"sphere": {"subdivisions": 3}}, "material": "ball_paint", "normals": "smooth",
                     "transform": {"scale": 0.5, "translate_m": [-0.5, 0.8, 0.0]}},
            "block": {"primitive": {"cube": {}}, "material": "block_paint", "normals": "flat", "pivot_m": place,
                      "transform": {"scale": size, "translate_m": place, "rotate": {"axis": [0.2, 1, 0.1], "angle_deg": 25}}}},
        "materials": {"floor_paint": {"model": "diffuse", "base_color": {"constant": of("floor_paint.base_color", [0.5, 0.5, 0.5])}},
                      "ball_paint": ball, "block_paint": {"model": "diffuse", "base_color": {"constant": [0.2, 0.5, 0.3]}}},
        "lights": {"key": {"type": "point", "position_m": [1.2, 2.6, 1.6], "intensity": of("key.intensity", [8.0, 8.0, 8.0])},
                   "fill": {"type": "constant", "radiance": of("fill.intensity", [0.2, 0.2, 0.2])}}}


def camera(turned):
    columns = look_at([0.0, 1.8, 3.2], [0, 0.5, 0])
    if not turned:
        return columns
    m, shift = rotation_matrix(POSE[0]), POSE[1]
    axes = [list(c) for c in zip(*product(m, [list(r) for r in zip(*columns[:3])]))]
    return axes + [[o + s for o, s in zip(columns[3], shift)]]


def fit_config(folder, name, photos, size, start):
    free, truth = CASES[name]
    turned = name == "camera"
    values = {**truth, **{k: v for k, v in free.items() if v}} if start else truth
    x, y, z, origin = columns = camera(turned and start)
    focal = 0.5 * size / math.tan(math.radians(FOV_DEG) / 2)
    described = scene(values, name == "gloss")
    if not start:
        rows = [[x[r], y[r], z[r], origin[r]] for r in range(3)] + [[0, 0, 0, 1]]
        gain = values.get("view.exr.exposure", [1.0])[0]
        described["sensors"] = {"view": {"size_px": [size, size], "focal_px": focal, "pose": {"world_from_camera": rows},
                                         "exposure_ev": math.log2(gain)}}
        return {"schema": 1, "seed": 1, "scene": described, "render": {"spp": PHOTO_SPP}}
    write_transforms(folder / f"{name}_cameras.json", [{"file": "view.exr", "size": (size, size), "focal": focal, "columns": columns}])
    source = {"images": str(photos), "cameras": {"path": str(folder / f"{name}_cameras.json"), "format": "transforms"},
              "split": {"validation": "none"}}
    if "view.exr.exposure" in free:
        source["exposure"] = {"model": "gain"}
    unknowns = {"exposure" if k == "view.exr.exposure" else k: {} for k in free}
    return {"schema": 1, "scene": described, "unknowns": unknowns, "stages": [{"name": "all", "free": "all"}], "input": source}


def true_values(name):
    """As parameters.csv names them."""
    _, truth = CASES[name]
    values = {}
    for key, numbers in truth.items():
        parts = ["r", "g", "b"] if key.endswith(("color", "intensity")) else ["x", "y", "z"]
        for part, number in zip(parts, numbers):
            values[key if len(numbers) == 1 else f"{key}.{part}"] = number
    return values


def run_one(args, folder, name, level, index):
    photos = folder / f"{name}_{level:g}" / str(1 + index)
    config = {**fit_config(folder, name, photos / "photos", args.size, True), "seed": 1000 + index}
    path = photos / "scatter.yaml"
    path.write_text(json.dumps(config, indent=1))
    done = subprocess.run([str(args.pathfit), "fit", str(path), "-o", str(photos / "run"), "--progress", "none", "-q", "--threads", "1"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{path}: {done.stderr[-1000:]}")
    rows = {r["name"]: r for r in read_scalars(photos / "run" / "result")}
    stage = json.loads((photos / "run" / "run.json").read_text())["stages"][-1]
    result = {"kept": stage["kept"], "stop": stage["stop_reason"], "rounds": stage["rounds"],
              "values": {k: (float(rows[k]["value"]), float(rows[k]["standard_error"] or "inf")) for k in true_values(name)}}
    if not args.keep:
        shutil.rmtree(photos)
    return result


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def compare(name, level, results):
    rows = []
    for key, truth in true_values(name).items():
        known = [r["values"][key] for r in results if math.isfinite(r["values"][key][1])]
        untold = len(results) - len(known)
        if len(known) < 3:
            rows.append({"case": name, "noise": level, "name": key, "truth": truth, "not determined": untold})
            continue
        values, errors = zip(*known)
        mean = sum(values) / len(values)
        scatter = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
        z = [(v - truth) / e for v, e in zip(values, errors)]
        error = statistics.median(errors)
        rows.append({"case": name, "noise": level, "name": key, "truth": truth, "scatter": scatter, "error": error, "ratio": scatter / error,
                     "bias": (mean - truth) / scatter * math.sqrt(len(values)), "z": rms(z), "within 1": sum(abs(x) <= 1 for x in z) / len(z),
                     "within 3": sum(abs(x) <= 3 for x in z) / len(z), "not determined": untold})
    return rows


def print_case(rows, results):
    rounds = sorted(r["rounds"] for r in results)
    kept = {k: sum(r["kept"] == k for r in results) for k in {r["kept"] for r in results}}
    print(f"{rows[0]['case']}, noise {rows[0]['noise']:g}: {rounds[0]} to {rounds[-1]} rounds, kept {kept}")
    for r in rows:
        untold = f"  not determined in {r['not determined']} fits" if r["not determined"] else ""
        if "ratio" not in r:
            print(f"  {r['name']:26} truth {r['truth']:8.4g}{untold}")
            continue
        print(f"  {r['name']:26} truth {r['truth']:8.4g}  scatter {r['scatter']:9.3g}  error {r['error']:9.3g}  ratio {r['ratio']:5.2f}  "
              f"mean off by {r['bias']:+5.1f}  z {r['z']:5.2f}  within 1: {r['within 1']:4.0%}  within 3: {r['within 3']:4.0%}{untold}")
    sys.stdout.flush()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pathfit", type=Path, required=True)
    parser.add_argument("--repeats", type=int, default=24)
    parser.add_argument("--jobs", type=int, default=1, help="fits at a time")
    parser.add_argument("--only", choices=list(CASES), nargs="+", default=list(CASES))
    parser.add_argument("--noise-levels", type=float, nargs="+", default=[0.0, 0.1], help="of the photos, in their mean")
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--keep", type=Path, help="configs, photos and runs stay here")
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    if args.repeats < 3:
        parser.error("--repeats: three at least")
    root = args.keep or Path(tempfile.mkdtemp(prefix="pathfit_errors_"))
    root = root.absolute()
    root.mkdir(parents=True, exist_ok=True)
    table = []
    try:
        for name in args.only:
            path = root / f"{name}_photo.yaml"
            path.write_text(json.dumps(fit_config(root, name, None, args.size, False), indent=1))
            for level in args.noise_levels:
                synth(args.pathfit, path, root / f"{name}_{level:g}", gaussian=level * MEAN, copies=args.repeats)
                with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
                    results = list(pool.map(lambda i: run_one(args, root, name, level, i), range(args.repeats)))
                rows = compare(name, level, results)
                print_case(rows, results)
                table += rows
                if args.out:
                    args.out.write_text(json.dumps(table, indent=1))
    finally:
        if not args.keep:
            shutil.rmtree(root, ignore_errors=True)
    ratios = [r["ratio"] for r in table if "ratio" in r]
    print(f"\n{len(ratios)} scalars, median ratio {sorted(ratios)[len(ratios) // 2]:.2f}, within a factor {LIMIT}: "
          f"{sum(1 / LIMIT <= r <= LIMIT for r in ratios)}")


if __name__ == "__main__":
    main()
