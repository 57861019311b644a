#!/usr/bin/env python3
"""Whole objects, fitted with defaults only: configs/objects/NAME.yaml, beside what is wanted of them.

fit_objects.py --pathfit BUILD/app/pathfit [--objects NAME ...] [--max-size N] [--time-limit TIME] [--threads N] [--keep-photos]
               [--spp N] [--runs FOLDER] [--set KEY=VALUE ...] [--out FILE.json]

Data: ../shared/datasets beside the repository; an object whose data are missing is skipped with a message. Photos with known
truth are made from configs/objects/SET_true.yaml into build/objects. Each object is checked, fitted and evaluated (relit
by an environment that no photo had). CPU: user seconds of the fit; MB: the most it held.
"""
import argparse
import json
import os
import shutil
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

from fit_runs import synth

SOURCE = Path(__file__).resolve().parents[2]
DATA = SOURCE.parent / "shared" / "datasets"
MADE = SOURCE / "build" / "objects"
RELIT_BY = DATA / "hdri" / "potsdamer_platz_1k.hdr"
# What is needed of the data, the set of made photos, and what is wanted.
OBJECTS = {
    "spot_material": (["meshes/spot", "hdri"], "spot_material", "base colour 1 %, roughness 0.02 rms where seen, 300 s"),
    "spot_all": (["meshes/spot", "hdri"], "spot_material", "surface 0.1 %, base colour 2 % after a factor, light 5 %, 1200 s"),
    "avocado": (["gltf/Avocado", "hdri"], "avocado", "relit 32 dB"),
    "skull": (["skull_flash"], None, "each stage lowers the held-out error"),
    "buddha": (["buddha_room"], None, "each stage lowers the held-out error"),
}
# What init makes beside a config, of which photos (and cameras).
BY_INIT = {"skull": (["skull_flash"], "skull_masks"), "buddha": (["buddha_room/gray/images", "buddha_room/gray/sparse/0"], "buddha_region")}
STOPPED = 75  # status of a fit that the time limit ended
# Where the cow shines, in its texture's picture: middle and radius of discs, the cow's spots among them.
DISCS = [(0.23, 0.25, 0.09), (0.30, 0.36, 0.10), (0.69, 0.20, 0.06), (0.82, 0.26, 0.08), (0.79, 0.50, 0.12),
         (0.70, 0.80, 0.09), (0.89, 0.74, 0.09), (0.27, 0.80, 0.10), (0.15, 0.58, 0.05), (0.39, 0.58, 0.05)]
MATT, GLOSSY, RIM = 0.5, 0.25, 0.15  # roughness outside and inside; half the width of the border in radii


def skip(text):
    print(f"*** SKIPPED: {text}. ***", file=sys.stderr)


def roughness_at(u, v):
    glossy = 0.0
    for x, y, radius in DISCS:
        t = min(max((1 + RIM - ((u - x) ** 2 + (v - y) ** 2) ** 0.5 / radius) / (2 * RIM), 0.0), 1.0)
        glossy = max(glossy, t * t * (3 - 2 * t))
    return MATT + (GLOSSY - MATT) * glossy


def write_gloss(path, size=256):
    """A grey PNG."""
    rows = b"".join(b"\0" + bytes(round(255 * roughness_at((x + 0.5) / size, (y + 0.5) / size)) for x in range(size)) for y in range(size))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", size, size, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def prepare(name, args):
    """Makes the photos. False: something is missing."""
    needed, photos, _ = OBJECTS[name]
    missing = [str(DATA / item) for item in needed if not (DATA / item).exists()]
    if missing:
        skip(f"{name} needs {', '.join(missing)}")
        return False
    if photos and not (args.keep_photos and (MADE / photos / "transforms.json").exists()):
        MADE.mkdir(parents=True, exist_ok=True)
        write_gloss(MADE / "spot_gloss.png")
        synth(args.pathfit, SOURCE / "configs" / "objects" / f"{photos}_true.yaml", MADE / photos)
        args.keep_photos = args.keep_photos or photos == "spot_material"  # which two objects share
    if name in BY_INIT:
        photos_of, made = BY_INIT[name]
        if not (args.keep_photos and (MADE / made).exists()):
            MADE.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(MADE / made, ignore_errors=True)
            subprocess.run([str(args.pathfit), "init", *(str(DATA / place) for place in photos_of), "-o", str(MADE / f"{name}.yaml"), "--force", "-q"],
                           check=True, stdout=subprocess.DEVNULL)
    return True


def run(args, *words):
    """Standard output, user seconds, MB and status."""
    started = time.monotonic()
    with subprocess.Popen([str(args.pathfit), *map(str, words)], stdout=subprocess.PIPE, text=True) as process:
        text = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return text, usage.ru_utime, usage.ru_maxrss / 1024, process.returncode, time.monotonic() - started


def fit(name, args):
    config, folder = SOURCE / "configs" / "objects" / f"{name}.yaml", args.runs / name
    changes = [word for change in args.set for word in ("--set", change)]
    if args.max_size:
        changes += ["--set", f"input.max_size_px={args.max_size}"]
    limit = ["--time-limit", args.time_limit] if args.time_limit else []
    threads = ["--threads", args.threads]
    _, _, _, status, _ = run(args, "check", config, "-q", "-o", str(folder) + "_check.html", *threads, *changes)
    if status != 0:
        raise RuntimeError(f"pathfit check {config} ended with {status}")
    _, cpu_s, peak_mb, status, wall_s = run(args, "fit", config, "-q", "-o", folder, *threads, *limit, *changes)
    if status not in (0, STOPPED):
        raise RuntimeError(f"pathfit fit {config} ended with {status}")
    photos = OBJECTS[name][1]
    truth = ["--truth", MADE / photos, "--env", RELIT_BY] if photos else []
    text, _, _, code, _ = run(args, "eval", folder, "--json", "-q", "--spp", args.spp, *threads, *truth)
    if code != 0:
        raise RuntimeError(f"pathfit eval {folder} ended with {code}")
    return {"object": name, "wanted": OBJECTS[name][2], "stopped": status == STOPPED, "cpu_s": round(cpu_s, 1), "wall_s": round(wall_s, 1),
            "peak_mb": round(peak_mb), "evaluation": json.loads(text)}


def figures(row):
    found = row["evaluation"]

    def number(value, unit, digits=3):
        return "-" if value is None else f"{value:.{digits}g} {unit}".strip()

    parts = [f"{key.replace('_', ' ')} {number((found.get(key) or {}).get('psnr_srgb_db'), 'dB', 4)}" for key in ("fitted", "held_out", "relit")]
    for entry in found.get("appearance") or []:
        if entry["surface"] == "seen":
            scaled = "" if entry["scaled_percent"] is None else f", {number(entry['scaled_percent'], '% scaled')}"
            parts.append(f"{entry['property']} {number(entry['rms'], '')} rms ({number(entry['rms_percent'], '%')}{scaled}), median {number(entry['median'], '')}")
    parts += [f"surface {number(s['mean_percent'], '%')}" for s in found.get("surfaces") or [] if s["surface"] == "seen"]
    parts += [f"light {number(s['radiance_percent'], '%')}, {number(s['scaled_percent'], '% scaled')}, of its texels {number(s['texels_scaled_percent'], '% scaled')}" for s in found.get("lights") or []]
    return "; ".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pathfit", type=Path, required=True)
    parser.add_argument("--objects", nargs="+", choices=list(OBJECTS), default=list(OBJECTS))
    parser.add_argument("--max-size", type=int)
    parser.add_argument("--time-limit")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--keep-photos", action="store_true")
    parser.add_argument("--runs", type=Path, default=MADE / "runs")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    args.runs.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in args.objects:
        if not prepare(name, args):
            continue
        rows.append(fit(name, args))
        row = rows[-1]
        print(f"{name}: {figures(row)}; {row['cpu_s']} CPU s, {row['peak_mb']} MB{', stopped' if row['stopped'] else ''} (wanted: {row['wanted']})", flush=True)
        if args.out:
            args.out.write_text(json.dumps(rows, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
