#!/usr/bin/env python3
"""Three inverse problems, solved by this program with defaults only and by Mitsuba 3 as its tutorials do, in one run.

fit_duels.py --pathfit BUILD/app/pathfit [--peer FOLDER] [--python PYTHON] [--distance BUILD/tests/surface_distance]
             [--duels NAME ...] [--cores N] [--repeats N] [--keep-photos] [--set KEY=VALUE ...] [--out FILE.json]

wall_colour needs nothing else. pose and shape need the meshes and duels.py of the peer's FOLDER, shape also the
program surface_distance; the peer's side needs a PYTHON with mitsuba. What is missing is skipped with a message.
Photos are rendered from configs/duel_NAME_true.yaml into build/duels, each side fits its own. Per round (peer: per
iteration) the error of the parameters is taken; a level counts as reached when the error stays below it from there
on. Seconds: of fitting alone, from after loading; ours include the report before the first round. CPU: user seconds
of the process over the same span, which other work on the machine disturbs less.
"""
import argparse
import json
import math
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fit_runs import peer_environment, pinned, product, read_table, rotation_angle, rotation_matrix, run_fit, synth, user_seconds

SOURCE = Path(__file__).resolve().parents[2]
DATA = SOURCE / "build" / "duels"
MESHES = {"wall_colour": [], "pose": ["bunny.ply"], "shape": ["suzanne.ply", "envmap2.exr"]}
# The error that is judged, and the levels of it whose times are wanted: level -> seconds on one core (issue 12).
ERRORS = {"wall_colour": "squared_error", "pose": "angle_deg", "shape": "distance_percent"}
WANTED = {"wall_colour": {1e-3: 0.5, 1e-4: 1.0, 1e-6: 3.0}, "pose": {4.7: None, 1.0: None, 0.3: None, 0.1: None, 0.03: 20.0},
          "shape": {1.18: None, 0.86: None, 0.57: None, 0.3: 60.0, 0.1: 600.0}}
TRUE_RED = (0.570068, 0.0430135, 0.0443706)
START_POSE = {"translation": (0.1, -0.25, 0.0), "angle_deg": 25.0}  # of configs/duel_pose.yaml
STOPPED = 75  # status of a fit that the time limit ended
PEER_OPTIONS = {"wall_colour": [], "pose": [], "shape": ["--spp", "16", "--iterations", "20"]}


def skip(text):
    print(f"*** SKIPPED: {text}; see tests/bench/README.md. ***", file=sys.stderr)


# Photos ----------------------------------------------------------------------------------------------------------------


def prepare(duel, args):
    """Meshes and photos. False: something is missing."""
    meshes = DATA / "meshes"
    for name in MESHES[duel]:
        if not (meshes / name).exists():
            if not args.peer:
                skip(f"{duel}: it needs {name} of the peer's scenes, --peer is not given")
                return False
            meshes.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(args.peer / "scenes" / name, meshes / name)
    if duel == "shape" and not args.distance:
        skip("shape: it needs --distance BUILD/tests/surface_distance")
        return False
    folder, config = DATA / duel, SOURCE / "configs" / f"duel_{duel}_true.yaml"
    if not (args.keep_photos and (folder / "transforms.json").exists()):
        synth(args.pathfit, config, folder)
    return True


# Errors ----------------------------------------------------------------------------------------------------------------


def wall_errors(values):
    red = values.get("red.base_color", (0.01, 0.2, 0.9))
    return {"squared_error": sum((a - b) ** 2 for a, b in zip(red, TRUE_RED))}


def pose_errors(values):
    start = rotation_matrix([0, math.radians(START_POSE["angle_deg"]), 0])
    turned = product(rotation_matrix(values.get("bunny.rotation", (0, 0, 0))), start)
    moved = [a + b for a, b in zip(START_POSE["translation"], values.get("bunny.translation", (0, 0, 0)))]
    return {"angle_deg": math.degrees(rotation_angle(turned)), "translation": math.sqrt(sum(x * x for x in moved))}


def write_ply(path, positions, triangles):
    """Both flat lists."""
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
              "element face {}\nproperty list uchar int vertex_indices\nend_header\n").format(len(positions) // 3, len(triangles) // 3)
    with open(path, "wb") as file:
        file.write(header.encode() + struct.pack(f"<{len(positions)}d", *positions))
        for i in range(0, len(triangles), 3):
            file.write(struct.pack("<B3i", 3, *triangles[i:i + 3]))


def read_triangles(path):
    """Of a binary PLY whose faces are the last element and lists of int indices alone: flat list, and the number of vertices."""
    data = Path(path).read_bytes()
    header = data[:data.index(b"end_header\n")].decode()
    vertices, faces = (int(re.search(rf"element {e} (\d+)", header).group(1)) for e in ("vertex", "face"))
    size = 13
    body = data[len(data) - size * faces:]
    triangles = [i for f in range(faces) for i in struct.unpack_from("<3i", body, size * f + 1)]
    if any(body[size * f] != 3 for f in range(faces)) or not all(0 <= i < vertices for i in triangles):
        raise ValueError(f"{path}: its faces are laid out in another way")
    return triangles, vertices


def distance(args, mesh):
    done = subprocess.run([str(args.distance), str(mesh), str(DATA / "meshes" / "suzanne.ply")], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)["mean_percent"]


def our_shape_rows(run, folder, args):
    triangles, count = read_triangles(folder / "result" / "head.ply")
    for r in run.rounds:
        positions, faces = next(iter(r.shapes.values()), (r.values.get("head.vertices"), triangles))
        if not positions or (not r.shapes and len(positions) != 3 * count):
            continue
        mesh = folder / "round.ply"
        write_ply(mesh, positions, faces)
        yield {"step": r.step, "seconds": r.wall_s, "cpu": r.user_s, "vertices": len(positions) // 3, "distance_percent": distance(args, mesh)}


# Both sides ------------------------------------------------------------------------------------------------------------


def our_side(duel, args, folder, repeat):
    more = [word for setting in args.set for word in ("--set", setting)] + ["--seed", str(7 + repeat)]
    if args.time_limit:
        more += ["--time-limit", f"{args.time_limit:g}s"]
    run = run_fit(args.pathfit, SOURCE / "configs" / f"duel_{duel}.yaml", folder, more, args.cores)
    if run.status not in (0, STOPPED):
        sys.exit(f"pathfit fit duel_{duel}.yaml ended with {run.status}:\n{run.messages[-2000:]}")
    if duel == "shape":
        rows = list(our_shape_rows(run, folder, args))
    else:
        errors = {"wall_colour": wall_errors, "pose": pose_errors}[duel]
        rows = [{"step": r.step, "seconds": r.wall_s, "cpu": r.user_s, **errors(r.values)} for r in run.rounds]
    metrics = read_table(folder / "metrics.csv")
    solving = sum(float(m[k]) for m in metrics for k in ("render_s", "jacobian_s", "linear_s"))
    stages = json.loads((folder / "run.json").read_text())["stages"]
    return {"rows": rows, "total_s": run.wall_s, "total_cpu": run.user_s, "rounds": len(metrics), "rounds_s": solving,
            "stop": [s["stop_reason"] for s in stages[1:]]}


def peer_side(duel, args, folder):
    out = ["--out", str(folder)] if duel == "shape" else []
    command = [str(args.python), "-u", str(args.peer / "duels.py"), duel, *PEER_OPTIONS[duel], *out]
    rows, first_cpu = [], None
    started = time.monotonic()
    with tempfile.TemporaryFile("w+") as messages, subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=messages, text=True, env=peer_environment(), preexec_fn=pinned(args.cores)) as process:
        for line in process.stdout:
            if not line.startswith("{"):
                continue
            row, cpu = json.loads(line), user_seconds(process.pid)
            # What came before the first line cannot be told from loading: it counts as its seconds.
            first_cpu = cpu - row["seconds"] if first_cpu is None else first_cpu
            row.update(step=row.pop("iteration") + 1, cpu=cpu - first_cpu)
            if duel == "pose":
                row.update(angle_deg=abs(row["angle_deg"]), translation=math.hypot(row["x"], row["y"]))
            rows.append(row)
            if args.time_limit and time.monotonic() - started > args.time_limit:
                process.kill()
        if process.wait() != 0 and not rows:
            messages.seek(0)
            sys.exit(f"the peer's {duel} failed:\n{messages.read()[-2000:]}")
    if duel == "shape":
        triangles, _ = read_triangles(args.peer / "scenes" / "ico_10k.ply")
        for row in rows:
            data = (folder / f"shape_{row['step'] - 1:03d}.npy").read_bytes()
            size = struct.unpack_from("<H", data, 8)[0]
            positions = [x for (x,) in struct.iter_unpack("<f", data[10 + size:])]
            write_ply(folder / "round.ply", positions, triangles)
            row["distance_percent"] = distance(args, folder / "round.ply")
    return {"rows": rows, "total_s": rows[-1]["seconds"], "total_cpu": rows[-1]["cpu"], "rounds": len(rows)}


# Results ---------------------------------------------------------------------------------------------------------------


def time_to(rows, error, level, clock):
    """When the error went below the level for good; None: never."""
    reached = None
    for row in rows:
        if row[error] > level:
            reached = None
        elif reached is None:
            reached = row[clock]
    return reached


def print_side(duel, name, side):
    error = ERRORS[duel]
    if not side["rows"]:
        print(f"  {name}: no rounds")
        return
    print(f"  {name}: {side['rounds']} rounds in {side['total_s']:.1f} s, CPU {side['total_cpu']:.1f} s")
    for level, wanted in WANTED[duel].items():
        seconds, cpu = (time_to(side["rows"], error, level, clock) for clock in ("seconds", "cpu"))
        figures = "never" if seconds is None else f"{seconds:8.2f} s   CPU {cpu:8.2f} s"
        goal = f"   (wanted on one core: {wanted:g} s)" if wanted and name.startswith("ours") else ""
        print(f"    {error} <= {level:<8g} {figures}{goal}")
    last = {k: v for k, v in side["rows"][-1].items() if k in ("squared_error", "angle_deg", "translation", "distance_percent", "vertices")}
    print("    at the end: " + ", ".join(f"{k} {v:.3g}" for k, v in last.items())
          + f"; best {min(r[error] for r in side['rows']):.3g}")
    for reason in side.get("stop", []):
        print(f"    stage ended: {reason}")
    sys.stdout.flush()


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pathfit", type=Path, required=True)
    parser.add_argument("--peer", type=Path)
    parser.add_argument("--python", type=Path)
    parser.add_argument("--distance", type=Path)
    parser.add_argument("--duels", nargs="+", choices=list(ERRORS), default=list(ERRORS))
    parser.add_argument("--cores", type=int, default=1, help="cores of each side; 0: all")
    parser.add_argument("--repeats", type=int, default=1, help="fits of ours, with different seeds")
    parser.add_argument("--keep-photos", action="store_true", help="use those of an earlier run")
    parser.add_argument("--time-limit", type=float, help="seconds of each side of each duel")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for experiments: of our config")
    parser.add_argument("--out", type=Path)
    return parser.parse_args()


def main():
    args = parse_arguments()
    with_peer = bool(args.peer and args.python)
    if not with_peer:
        skip("the peer's side: it needs --peer FOLDER and --python PYTHON")
    report = {}
    for duel in args.duels:
        if not prepare(duel, args):
            continue
        print(f"\n{duel}")
        report[duel] = {}
        with tempfile.TemporaryDirectory(prefix="pathfit_duel_") as temporary:
            for repeat in range(args.repeats):
                name = f"ours, seed {7 + repeat}"
                report[duel][name] = our_side(duel, args, Path(temporary) / f"ours{repeat}", repeat)
                print_side(duel, name, report[duel][name])
            if with_peer:
                report[duel]["peer"] = peer_side(duel, args, Path(temporary))
                print_side(duel, "peer", report[duel]["peer"])
        if args.out:
            args.out.write_text(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
