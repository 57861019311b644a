#!/usr/bin/env python3
"""How far the normals of a fitted surface are from those of classical photometric stereo. Needs NumPy and OpenCV for Python.

normal_angles.py MESH.ply --config configs/tutorials/photometric_stereo/cat.yaml [--erode PIXELS] [--out ANGLES.png]

Classical: per pixel of the config's photos and mask the least-squares normal of a matt surface under the config's directional
lamps, first of all photos, then of those whose lamp is in front of it and whose value is neither far too dark (a cast shadow)
nor far too bright (a highlight).
The mesh as the config's orthographic camera along -z sees it, normals of its triangles and smooth ones.
"""
import argparse
import json
from pathlib import Path

import cv2
import numpy as np
import yaml

SHADOW, HIGHLIGHT = 0.6, 1.5  # of the expected value


def read_ply(path):
    with open(path, "rb") as file:
        counts, kind, columns, current = {}, "", {}, ""
        while (line := file.readline().decode().split()) != ["end_header"]:
            if line[0] == "format":
                kind = line[1]
            elif line[0] == "element":
                current = line[1]
                counts[current], columns[current] = int(line[2]), []
            elif line[0] == "property":
                columns[current].append(line[1:])
        types = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4", "float32": "<f4", "uint8": "u1", "int32": "<i4"}
        assert kind == "binary_little_endian"
        vertices = np.fromfile(file, np.dtype([(c[1], types[c[0]]) for c in columns["vertex"]]), counts["vertex"])
        faces = np.fromfile(file, np.dtype([("n", types[columns["face"][0][1]]), ("v", types[columns["face"][0][2]], 3)]), counts["face"])
    return np.stack([vertices[k] for k in "xyz"], 1).astype(float), faces["v"].astype(int)


def unit(v):
    return v / np.maximum(1e-12, np.linalg.norm(v, axis=-1, keepdims=True))


def classical(config, folder):
    lamps = config["scene"]["lights"].values()
    photos = folder / config["input"]["images"]
    files = [next(photos.glob(lamp["photos"][0] + ".*")) for lamp in lamps]
    values = np.stack([cv2.imread(str(f), cv2.IMREAD_GRAYSCALE).astype(float) / 255 for f in files])
    mask = cv2.imread(str(folder / config["input"]["masks"]["path"]), cv2.IMREAD_GRAYSCALE) > 127
    light = np.stack([-unit(np.array(lamp["direction"], float)) * lamp["irradiance"][1] for lamp in lamps])
    pixels = values[:, mask].T
    used = np.ones_like(pixels)
    for _ in range(4):
        matrix = np.einsum("pk,ki,kj->pij", used, light, light) + 1e-9 * np.eye(3)
        normals = np.linalg.solve(matrix, np.einsum("pk,ki,pk->pi", used, light, pixels)[..., None])[..., 0]
        expected = normals @ light.T
        used = ((expected > 0) & (pixels > SHADOW * expected) & (pixels < HIGHLIGHT * expected)).astype(float)
        used[used.sum(1) < 4] = 1.0
    result = np.zeros(mask.shape + (3,))
    result[mask] = unit(normals)
    return result, mask


def rasterise(positions, triangles, camera, shape):
    height_px, width_px = shape
    scale = height_px / camera["height_m"]
    x = width_px / 2 + positions[:, 0] * scale
    y = height_px / 2 - positions[:, 1] * scale
    corners = positions[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = unit(area)
    smooth = np.zeros_like(positions)
    for k in range(3):
        np.add.at(smooth, triangles[:, k], area)
    smooth = unit(smooth)
    depth = np.full(shape, -np.inf)
    of_faces, of_vertices = np.zeros(shape + (3,)), np.zeros(shape + (3,))
    for t in np.flatnonzero(flat[:, 2] > 0):
        a, b, c = triangles[t]
        px, py = x[[a, b, c]], y[[a, b, c]]
        x0, x1 = max(0, int(np.floor(px.min() - 0.5))), min(width_px - 1, int(np.ceil(px.max() - 0.5)))
        y0, y1 = max(0, int(np.floor(py.min() - 0.5))), min(height_px - 1, int(np.ceil(py.max() - 0.5)))
        det = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0])
        if x1 < x0 or y1 < y0 or det == 0:
            continue
        gx, gy = np.meshgrid(np.arange(x0, x1 + 1) + 0.5, np.arange(y0, y1 + 1) + 0.5)
        v = ((gx - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (gy - py[0])) / det
        w = ((px[1] - px[0]) * (gy - py[0]) - (gx - px[0]) * (py[1] - py[0])) / det
        u = 1 - v - w
        z = u * positions[a, 2] + v * positions[b, 2] + w * positions[c, 2]
        window = (slice(y0, y1 + 1), slice(x0, x1 + 1))
        nearer = (u >= 0) & (v >= 0) & (w >= 0) & (z > depth[window])
        depth[window][nearer] = z[nearer]
        of_faces[window][nearer] = flat[t]
        of_vertices[window][nearer] = unit(u[nearer, None] * smooth[a] + v[nearer, None] * smooth[b] + w[nearer, None] * smooth[c])
    return of_faces, of_vertices, np.isfinite(depth)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--config", required=True, type=Path)
    parser.add_argument("--erode", type=int, default=0)
    parser.add_argument("--out", type=Path, help="angles, white is 30 degrees")
    args = parser.parse_args()
    config = yaml.safe_load(args.config.read_text())
    truth, mask = classical(config, args.config.parent)
    camera = config["scene"]["sensors"][config["input"]["cameras"]["sensor"]]
    of_faces, of_vertices, covered = rasterise(*read_ply(args.mesh), camera, mask.shape)
    if args.erode:
        mask = cv2.erode(mask.astype(np.uint8), np.ones((3, 3)), iterations=args.erode) > 0
    seen = mask & covered
    angles = {}
    for name, normals in (("triangles", of_faces), ("smooth", of_vertices)):
        angle = np.degrees(np.arccos(np.clip((normals * truth).sum(-1), -1, 1)))
        angles[name] = {"mean": float(angle[seen].mean()), "median": float(np.median(angle[seen])), "p90": float(np.percentile(angle[seen], 90))}
    print(json.dumps({"pixels": int(seen.sum()), "covered": float(seen.sum() / mask.sum()), "degrees": angles}))
    if args.out:
        cv2.imwrite(str(args.out), np.where(seen, np.clip(angle / 30 * 255, 0, 255), 0).astype(np.uint8))


if __name__ == "__main__":
    main()
