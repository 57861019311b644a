#!/usr/bin/env python3
"""Fits of random small scenes with known truth, with defaults only: a search for what the fit cannot do.

random_fits.py --pathfit BUILD/app/pathfit [--count N] [--seed N] [--jobs N] [--only I ...]
               [--timeout S] [--keep DIR] [--out FILE.json]

Scene I of a seed is the same for every count. Each has a floor, one to three objects, one or two lights, one to three
cameras of 48 x 48 pixels, 1 to 200 unknowns of one to four kinds with a random start, photos with noise from none to 20 %
of their mean, and up to 10 % of error in what the fit believes to know. Reported of each: the cost at the start, at
the end and at the truth (whose error of the model stays), the share of the way to the truth that is left per kind,
and, where a run's result has standard errors, deviations from the truth in standard errors.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import shutil
import statistics
import struct
import sys
import tempfile
import zlib
from pathlib import Path

from fit_runs import look_at, normalised, product, read_scalars, rotation_matrix, rotation_vector, run_fit, synth, write_transforms

SIZE = 48
FOV_DEG = 45.0
PHOTO_SPP = 256
# A fit counts as arrived if of the way that the cost has to go from the start to the truth no more is left than this.
LEFT_OF_COST = 0.01
LEFT_OF_WAY = math.sqrt(LEFT_OF_COST)
# And to this share of the truth's cost, where the noise of the photos is what is left.
COST_SLACK = 0.02
SIGMAS = 3.0


# Scenes ----------------------------------------------------------------------------------------------------------------


def icosphere():
    """Vertices and triangles of an icosahedron split once: 42 vertices of radius 1."""
    g = (1 + math.sqrt(5)) / 2
    points = [normalised(p) for a in (-1, 1) for b in (-g, g) for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    edge = min(math.dist(points[0], p) for p in points[1:])
    near = [[j for j in range(12) if j != i and math.dist(points[i], points[j]) < 1.1 * edge] for i in range(12)]
    faces = [(i, j, k) for i in range(12) for j in near[i] if j > i for k in near[i] if k > j and k in near[j]]
    middle, triangles = {}, []

    def between(i, j):
        key = (min(i, j), max(i, j))
        if key not in middle:
            middle[key] = len(points)
            points.append(normalised([(a + b) / 2 for a, b in zip(points[i], points[j])]))
        return middle[key]

    for i, j, k in faces:
        a, b, c = between(i, j), between(j, k), between(k, i)
        triangles += [(i, a, c), (a, j, b), (c, b, k), (a, b, c)]
    outward = []
    for t in triangles:
        p, q, r = (points[i] for i in t)
        u, v = [b - a for a, b in zip(p, q)], [b - a for a, b in zip(p, r)]
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        outward.append(list(t if sum(a * b for a, b in zip(n, p)) > 0 else (t[0], t[2], t[1])))
    return points, outward


def srgb_decoded(byte):
    x = byte / 255.0
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def write_png(path, width, height, rows):
    """8 bit RGB; `rows` from the top, of bytes."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + bytes(row) for row in rows)
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                           + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def write_hdr(path, width, height, texels):
    """Radiance; texels are lists of three, from the top. Returns what the file holds."""
    data, held = bytearray(), []
    for rgb in texels:
        mantissa, exponent = math.frexp(max(rgb))
        values = [min(255, int(v / max(rgb) * mantissa * 256.0)) for v in rgb]
        data += bytes(values) + bytes([exponent + 128])
        held.append([(v + 0.5) * 2.0 ** (exponent - 8) for v in values])
    Path(path).write_bytes(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + data)
    return held


class Problem:
    """One random scene: numbers by name in `truth` and `start`, and how they become a config."""

    def __init__(self, seed, index):
        self.rng = rng = random.Random(f"{seed} {index}")
        self.index = index
        self.truth, self.start, self.model_error = {}, {}, {}
        self.unknowns, self.kinds = [], []
        self.objects = [{"name": f"object{i}", "shape": rng.choice(["sphere", "cube"]), "glossy": rng.random() < 0.4}
                        for i in range(rng.randint(1, 3))]
        angle = rng.uniform(0, 2 * math.pi)
        for i, o in enumerate(self.objects):
            a, r = angle + 2 * math.pi * i / len(self.objects), rng.uniform(0.5, 0.9) if len(self.objects) > 1 else rng.uniform(0, 0.3)
            size = rng.uniform(0.3, 0.45)
            self.both(f"{o['name']}.size", size)
            self.both(f"{o['name']}.place", [r * math.cos(a), 1.8 * size + rng.uniform(0.25, 0.4), r * math.sin(a)])  # off the floor, turned and moved too
            axis = normalised([rng.gauss(0, 1) for _ in range(3)])
            self.both(f"{o['name']}.turn", [rng.uniform(0, 1) * x for x in axis])
            self.both(f"{o['name']}.color", [rng.uniform(0.15, 0.85) for _ in range(3)])
            for key, low, high in (("roughness", 0.25, 0.8), ("metallic", 0.1, 0.9), ("specular", 0.2, 1.0)):
                self.both(f"{o['name']}.{key}", rng.uniform(low, high))
        self.both("floor.color", [rng.uniform(0.3, 0.7) for _ in range(3)])
        self.key = rng.choice(["point", "spot", "directional", "rectangle"])
        a, height = rng.uniform(0, 2 * math.pi), rng.uniform(2.0, 3.0)
        self.both("key.place", [1.5 * math.cos(a), height, 1.5 * math.sin(a)])
        self.both("key.direction", normalised([-1.5 * math.cos(a), -height, -1.5 * math.sin(a)]))
        unit = {"point": 12.0, "spot": 14.0, "directional": 2.5, "rectangle": 14.0}[self.key]
        self.both("key.power", [unit * rng.uniform(0.7, 1.3) for _ in range(3)])
        self.both("key.angles", [math.radians(rng.uniform(14, 18)), math.radians(rng.uniform(24, 30))])
        self.both("ambient.power", [rng.uniform(0.1, 0.3) for _ in range(3)])
        self.cameras = rng.randint(1, 3)
        turn = rng.uniform(0, 2 * math.pi)
        for i in range(self.cameras):
            a, height = turn + i * 2 * math.pi / 3 + rng.uniform(-0.3, 0.3), rng.uniform(1.5, 2.5)
            self.both(f"camera{i}.place", [3.2 * math.cos(a), height, 3.2 * math.sin(a)])
            self.both(f"camera{i}.turn", [0.0, 0.0, 0.0])
        self.both("focal", 0.5 * SIZE / math.tan(math.radians(FOV_DEG) / 2))
        self.both("gains", [1.0] * self.cameras)
        self.choose_unknowns()
        self.noise = rng.choice([("gaussian", 0.0), ("gaussian", 0.005), ("gaussian", 0.03), ("gaussian", 0.2),
                                 ("shot", 0.02), ("shot", 0.1)])
        self.error = rng.choice([0.0, 0.0, 0.01, 0.03, 0.1])
        self.add_model_error()

    def both(self, name, value):
        self.truth[name] = self.start[name] = value

    # Unknowns: the name in configs, the key of `truth`, what the state's numbers must become.

    def free(self, kind, name, key, start, truth_values, start_values):
        self.start[key] = start
        self.kinds.append(kind)
        self.unknowns.append({"kind": kind, "name": name, "truth": truth_values, "start": start_values})

    def choose_unknowns(self):
        rng = self.rng
        makers = ["color", "color", "gloss", "power", "light_place", "light_direction", "spot_angles", "translation", "rotation", "scale",
                  "camera_position", "camera_rotation", "focal", "vertex_colors", "vertices", "texels", "environment", "exposure"]
        # Pairs that no photo tells apart, or too many numbers together.
        conflicts = [{"texels", "power"}, {"environment", "power"}, {"environment", "exposure"}, {"camera_position", "focal"}]
        many = {"vertices", "vertex_colors", "texels", "environment"}
        wanted, done = rng.randint(1, 4), []
        rng.shuffle(makers)
        for maker in makers:
            if len(done) == wanted:
                break
            if any({maker, d} in conflicts or {maker, d} <= many for d in done):
                continue
            if getattr(self, "free_" + maker)():
                done.append(maker)

    def fresh_object(self, want=lambda o: True):
        """An object that has no unknown of its own yet."""
        candidates = [o for o in self.objects if not o.get("used") and want(o)]
        if not candidates:
            return None
        chosen = self.rng.choice(candidates)
        chosen["used"] = True
        return chosen

    def free_color(self):
        o = self.fresh_object()
        if o:
            name = o["name"]
            self.free("colour", f"{name}_paint.base_color", f"{name}.color", [0.5] * 3, self.truth[f"{name}.color"], [0.5] * 3)
        return o

    def free_gloss(self):
        o = self.fresh_object()
        if o:
            o["glossy"] = True
            for key in self.rng.sample(["roughness", "metallic", "specular"], self.rng.randint(1, 3)):
                name, start = o["name"], {"roughness": 0.5, "metallic": 0.5, "specular": 0.6}[key]
                self.free(key, f"{name}_paint.{key}", f"{name}.{key}", start, [self.truth[f"{name}.{key}"]], [start])
        return o

    def free_power(self):
        light = self.rng.choice(["key", "ambient"])
        factor = 2.0 ** self.rng.uniform(-3, 3)
        truth = self.truth[f"{light}.power"]
        start = [factor * sum(truth) / 3] * 3
        self.free("power", f"{light}.intensity", f"{light}.power", start, truth, start)
        return True

    def free_light_place(self):
        if self.key not in ("point", "spot", "rectangle"):
            return False
        offset = [self.rng.uniform(-0.5, 0.5) for _ in range(3)]
        truth = self.truth["key.place"]
        start = [a + b for a, b in zip(truth, offset)]
        if self.key == "rectangle":
            self.free("light place", "key.translation", "key.place", start, [-x for x in offset], [0.0] * 3)
        else:
            self.free("light place", "key.position", "key.place", start, truth, start)
        return True

    def free_light_direction(self):
        if self.key not in ("spot", "directional"):
            return False
        turn = [self.rng.gauss(0, 0.12) for _ in range(3)]
        truth = self.truth["key.direction"]
        m = rotation_matrix(turn)
        start = [sum(m[i][k] * truth[k] for k in range(3)) for i in range(3)]
        # The part of the turn about the direction itself is not seen: only directions are compared.
        self.free("light direction", "key.rotation", "key.direction", start, truth, start)
        self.unknowns[-1]["turns"] = start
        return True

    def free_spot_angles(self):
        if self.key != "spot":
            return False
        truth = self.truth["key.angles"]
        start = [truth[0] * self.rng.uniform(0.7, 1.1), truth[1] * self.rng.uniform(0.9, 1.3)]
        self.free("spot angles", "key.angles", "key.angles", start, truth, start)
        return True

    def free_translation(self):
        o = self.fresh_object()
        if o:
            key = f"{o['name']}.place"
            offset = [self.rng.uniform(-0.2, 0.2) for _ in range(3)]
            start = [a + b for a, b in zip(self.truth[key], offset)]
            self.free("translation", f"{o['name']}.translation", key, start, [-x for x in offset], [0.0] * 3)
        return o

    def free_rotation(self):
        o = self.fresh_object(lambda o: o["shape"] == "cube")
        if o:
            key = f"{o['name']}.turn"
            turn = [self.rng.gauss(0, 0.2) for _ in range(3)]
            start = rotation_vector(product(rotation_matrix(turn), rotation_matrix(self.truth[key])))
            self.free("rotation", f"{o['name']}.rotation", key, start, [-x for x in turn], [0.0] * 3)
        return o

    def free_scale(self):
        o = self.fresh_object()
        if o:
            key, factor = f"{o['name']}.size", self.rng.choice([0.75, 0.85, 1.15, 1.3])
            self.free("scale", f"{o['name']}.scale", key, factor * self.truth[key], [1 / factor], [1.0])
        return o

    def free_camera_position(self):
        i = self.rng.randrange(self.cameras)
        truth = self.truth[f"camera{i}.place"]
        start = [a + self.rng.gauss(0, 0.04) for a in truth]
        self.free("camera position", f"view{i}.exr.position", f"camera{i}.place", start, truth, start)
        return True

    def free_camera_rotation(self):
        i = self.rng.randrange(self.cameras)
        turn = [self.rng.gauss(0, 0.015) for _ in range(3)]
        self.free("camera rotation", f"view{i}.exr.rotation", f"camera{i}.turn", turn, [-x for x in turn], [0.0] * 3)
        return True

    def free_focal(self):
        truth = self.truth["focal"]
        start = truth * (1 + self.rng.gauss(0, 0.015))
        for i in range(self.cameras):
            self.free("focal", f"view{i}.exr.focal", "focal", start, [truth] * 2, [start] * 2)
        return True

    def free_vertex_colors(self):
        o = self.fresh_object(lambda o: o["shape"] == "sphere")
        if o:
            points, _ = icosphere()
            phase = [self.rng.uniform(0, 6) for _ in range(3)]
            colors = [[0.5 + 0.3 * math.sin(3 * x + 2 * y * p - z + p) for p in phase] for x, y, z in points]
            o["colors"] = True
            self.both(f"{o['name']}.colors", colors)
            start = [[0.5] * 3] * len(points)
            self.free("vertex colours", f"{o['name']}.colors", f"{o['name']}.colors", start, sum(colors, []), sum(start, []))
        return o

    def free_vertices(self):
        o = self.fresh_object(lambda o: o["shape"] == "sphere")
        if o:
            key = f"{o['name']}.points"
            points, _ = icosphere()
            size, place = self.truth[f"{o['name']}.size"], self.truth[f"{o['name']}.place"]
            bump = [self.rng.gauss(0, 0.12) for _ in range(6)]
            start = [[s + size * x for s, x in zip(place, p)] for p in points]
            truth = [[s + size * x * (1 + bump[0] * p[0] + bump[1] * p[1] * p[2] + bump[2] * p[0] * p[1] + bump[3] * p[1]) for s, x in zip(place, p)]
                     for p in points]
            o["vertices"] = True
            self.both(key, truth)
            self.free("vertices", f"{o['name']}.vertices", key, start, sum(truth, []), sum(start, []))
        return o

    def free_texels(self):
        width = height = self.rng.choice([3, 5, 7])
        self.texels = [[self.rng.randrange(90, 230) for _ in range(3 * width)] for _ in range(height)]
        values = [srgb_decoded(b) for row in self.texels for b in row]
        self.texture_size = (width, height)
        self.both("texels", True)
        self.free("texels", "picture.texels", "texels", False, values, [0.5] * len(values))
        return True

    def free_environment(self):
        self.sky = [[self.rng.uniform(0.05, 0.6) for _ in range(3)] for _ in range(32)]
        self.both("sky", True)
        self.free("environment", "ambient.texels", "sky", False, None, [0.3] * 96)
        return True

    def free_exposure(self):
        if self.cameras < 2:
            return False
        evs = [self.rng.gauss(0, 0.3) for _ in range(self.cameras)]
        mean = sum(evs) / len(evs)
        gains = [2.0 ** (ev - mean) for ev in evs]
        self.truth["gains"] = gains
        for i, gain in enumerate(gains):
            self.free("exposure", f"view{i}.exr.exposure", "gains", [1.0] * self.cameras, [gain], [1.0])
        return True

    def add_model_error(self):
        """Something the fit is sure of is different in the photos."""
        if self.error == 0.0:
            return
        freed = {u["name"] for u in self.unknowns}
        keys = [k for k, names in (("floor.color", ("picture.texels",)), ("ambient.power", ("ambient.intensity", "ambient.texels")),
                                   ("key.power", ("key.intensity",))) if not freed.intersection(names)]
        key = self.rng.choice(keys)
        self.model_error[key] = [x * (1 + self.error * self.rng.choice([-1, 1])) for x in self.truth[key]]

    # Configs.

    def scene(self, values, folder):
        geometry = {"floor": {"primitive": {"rectangle": {}}, "material": "floor_paint", "normals": "flat",
                              "transform": {"scale": 2.5, "rotate": {"axis": [1, 0, 0], "angle_deg": -90}}}}
        materials = {"floor_paint": {"model": "diffuse", "base_color": {"constant": values["floor.color"]}}}
        textures = {}
        if "texels" in values:
            width, height = self.texture_size
            textures["picture"] = {"file": str(folder / "picture.png")} if values["texels"] else {"size_px": [width, height]}
            materials["floor_paint"]["base_color"] = {"texture": "picture"}
        for o in self.objects:
            name = o["name"]
            turn = values[f"{name}.turn"]
            angle = math.sqrt(sum(x * x for x in turn))
            place = values[f"{name}.place"]
            transform = {"scale": values[f"{name}.size"], "translate_m": place}
            if o["shape"] == "cube" and angle > 0:
                transform["rotate"] = {"axis": turn, "angle_deg": math.degrees(angle)}
            entry = {"material": f"{name}_paint", "transform": transform, "pivot_m": place}
            if o["shape"] == "cube":
                entry.update(primitive={"cube": {}}, normals="flat")
            else:
                entry.update(primitive={"sphere": {"subdivisions": 3}}, normals="smooth")
            if o.get("colors") or o.get("vertices"):
                points, triangles = icosphere()
                entry.pop("primitive")
                entry["mesh"] = {"vertices": points, "triangles": triangles}
                if o.get("colors"):
                    entry["mesh"]["colors"] = values[f"{name}.colors"]
                if o.get("vertices"):
                    entry["mesh"]["vertices"] = values[f"{name}.points"]
                    entry["normals"] = "flat"
                    entry.pop("transform"), entry.pop("pivot_m")
            geometry[name] = entry
            color = {"vertex": "mesh"} if o.get("colors") else {"constant": values[f"{name}.color"]}
            if o["glossy"]:
                materials[f"{name}_paint"] = {"model": "metallic_roughness", "base_color": color, "specular": values[f"{name}.specular"],
                                              "roughness": {"constant": values[f"{name}.roughness"]}, "metallic": {"constant": values[f"{name}.metallic"]}}
            else:
                materials[f"{name}_paint"] = {"model": "diffuse", "base_color": color}
        key = {"type": self.key}
        if self.key == "rectangle":
            tilt = rotation_between([0, 0, 1], values["key.direction"])
            key.update(position_m=values["key.place"], width_m=0.8, height_m=0.6, radiance=values["key.power"],
                       rotate={"axis": normalised(tilt), "angle_deg": math.degrees(math.sqrt(sum(x * x for x in tilt)))})
        elif self.key == "directional":
            key.update(direction=values["key.direction"], irradiance=values["key.power"])
        else:
            key.update(position_m=values["key.place"], intensity=values["key.power"])
            if self.key == "spot":
                inner, outer = (math.degrees(a) for a in values["key.angles"])
                key.update(direction=values["key.direction"], inner_deg=inner, outer_deg=outer)
        ambient = {"type": "constant", "radiance": values["ambient.power"]}
        if "sky" in values:
            ambient = {"type": "envmap", "file": str(folder / "sky.hdr")} if values["sky"] else {
                "type": "envmap", "size_px": [8, 4], "init": {"constant": [0.3, 0.3, 0.3]}}
        scene = {"geometry": geometry, "materials": materials, "lights": {"key": key, "ambient": ambient}}
        if textures:
            scene["textures"] = textures
        return scene

    def camera_columns(self, values, i):
        columns = look_at(values[f"camera{i}.place"], [0, 0.3, 0])
        true = look_at(self.truth[f"camera{i}.place"], [0, 0.3, 0])  # the start looks where the truth does
        turn = rotation_matrix(values[f"camera{i}.turn"])
        return [[sum(turn[r][k] * c[k] for k in range(3)) for r in range(3)] for c in true[:3]] + [columns[3]]

    def photo_config(self, folder):
        values = {**self.truth, **self.model_error}
        sensors = {}
        for i in range(self.cameras):
            x, y, z, origin = self.camera_columns(values, i)
            rows = [[x[r], y[r], z[r], origin[r]] for r in range(3)] + [[0, 0, 0, 1]]
            sensors[f"view{i}"] = {"size_px": [SIZE, SIZE], "focal_px": values["focal"], "pose": {"world_from_camera": rows},
                                   "exposure_ev": math.log2(values["gains"][i])}
        return {"schema": 1, "seed": self.index, "scene": {**self.scene(values, folder), "sensors": sensors}, "render": {"spp": PHOTO_SPP}}

    def fit_config(self, values, folder, name):
        cameras = [{"file": f"view{i}.exr", "size": (SIZE, SIZE), "focal": values["focal"], "columns": self.camera_columns(values, i)}
                   for i in range(self.cameras)]
        write_transforms(folder / f"{name}_cameras.json", cameras)
        source = {"images": str(folder / "synth" / "photos"), "cameras": {"path": str(folder / f"{name}_cameras.json"), "format": "transforms"},
                  "split": {"validation": "none"}}
        if "exposure" in self.kinds:
            source["exposure"] = {"model": "gain"}
        return {"schema": 1, "seed": self.index, "input": source, "scene": self.scene(values, folder),
                "unknowns": {"exposure" if u["kind"] == "exposure" else u["name"]: {} for u in self.unknowns}, "stages": [{"name": "all", "free": "all"}]}

    def write(self, folder, pathfit):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        if "texels" in self.truth:
            width, height = self.texture_size
            write_png(folder / "picture.png", width, height, self.texels)
        if "sky" in self.truth:
            held = write_hdr(folder / "sky.hdr", 8, 4, self.sky)
            next(u for u in self.unknowns if u["kind"] == "environment")["truth"] = sum(held, [])
        for name, config in (("photos", self.photo_config(folder)), ("fit", self.fit_config(self.start, folder, "fit")),
                             ("truth", self.fit_config(self.truth, folder, "truth"))):
            (folder / f"{name}.yaml").write_text(json.dumps(config, indent=1))
        kind, level = self.noise
        mean = 0.3  # of these pictures, about
        amount = {"gaussian": level * mean} if kind == "gaussian" else {"shot": level * level * mean}
        synth(pathfit, folder / "photos.yaml", folder / "synth", **amount)


def rotation_between(a, b):
    """A rotation vector that turns the unit vector a into b."""
    axis = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    sine, cosine = math.sqrt(sum(x * x for x in axis)), sum(x * y for x, y in zip(a, b))
    if sine < 1e-12:
        return [0.0, 1e-9 if cosine > 0 else math.pi, 0.0]
    return [x / sine * math.atan2(sine, cosine) for x in axis]


# Runs ------------------------------------------------------------------------------------------------------------------


def compare(unknown, values):
    """Median distance to the truth at the end over that at the start (some texels are hidden), and the rms of the former."""
    if "turns" in unknown:
        m = rotation_matrix(values)
        values = [sum(m[i][k] * unknown["turns"][k] for k in range(3)) for i in range(3)]
    if len(values) != len(unknown["truth"]):
        return None
    if len(values) > 6:
        before, after = (statistics.median(abs(a - b) for a, b in zip(v, unknown["truth"])) for v in (unknown["start"], values))
    else:
        before, after = (math.dist(v, unknown["truth"]) for v in (unknown["start"], values))
    return {"kind": unknown["kind"], "name": unknown["name"], "scalars": len(values), "left": after / before if before else after,
            "rms": math.dist(values, unknown["truth"]) / math.sqrt(len(values))}


def in_standard_errors(problem, table):
    """(value - truth) / standard error of the scalars that have both."""
    deviations = {}
    for u in problem.unknowns:
        if "turns" in u or len(u["truth"]) > 3:
            continue
        rows = [r for r in table if r["name"] == u["name"] or r["name"].startswith(u["name"] + ".")]
        if len(rows) != len(u["truth"]):
            continue
        for row, truth in zip(rows, u["truth"]):
            try:
                error = float(row["standard_error"])
            except (KeyError, ValueError):
                continue
            if error > 0 and math.isfinite(error):
                deviations[row["name"]] = (float(row["value"]) - truth) / error
    return deviations


def stage_costs(folder):
    stages = json.loads((folder / "run.json").read_text())["stages"]
    return stages[1:]


def solve(args, index, root):
    problem = Problem(args.seed, index)
    folder = root / f"scene{index:03d}"
    row = {"scene": index, "kinds": problem.kinds, "scalars": sum(len(u["start"]) for u in problem.unknowns), "cameras": problem.cameras,
           "light": problem.key, "noise": list(problem.noise), "model_error": problem.error}
    try:
        problem.write(folder, args.pathfit)
    except RuntimeError as error:
        return {**row, "outcome": "no photos", "messages": str(error)}
    run = run_fit(args.pathfit, folder / "fit.yaml", folder / "run", ["--threads", args.threads], timeout_s=args.timeout)
    row.update(status=run.status, cpu_s=run.user_s, messages=run.messages[-1000:])
    if run.status is None:
        return {**row, "outcome": "timeout"}
    if run.status != 0:
        return {**row, "outcome": "failed"}
    stages = stage_costs(folder / "run")
    # Gains cannot be given beforehand: they alone are fitted where all else is true.
    has_gains = "exposure" in problem.kinds
    more = "stages[0].free=[exposure]" if has_gains else "stages[0].max_rounds=1"
    at_truth = run_fit(args.pathfit, folder / "truth.yaml", folder / "run_truth", ["--threads", args.threads, "--set", more], timeout_s=args.timeout)
    if at_truth.status != 0:
        return {**row, "outcome": "failed at the truth", "messages": at_truth.messages[-1000:]}
    row.update(cost_start=stages[0]["cost_before"], cost_end=stages[-1]["cost_after"], kept=stages[-1]["kept"],
               stop=stages[-1]["stop_reason"], rounds=sum(s["rounds"] for s in stages),
               cost_truth=stage_costs(folder / "run_truth")[-1]["cost_after" if has_gains else "cost_before"])
    values = run.rounds[-1].values if run.rounds else {}
    row["errors"] = [c for c in (compare(u, values.get(u["name"], [0.0] * 3 if "turns" in u else u["start"])) for u in problem.unknowns) if c]
    row["deviations"] = in_standard_errors(problem, read_scalars(folder / "run" / "result"))
    row["outcome"] = judge(row)
    return row


def judge(row):
    start, end, truth = row["cost_start"], row["cost_end"], row["cost_truth"]
    numbers = [start, end, truth, *(e["left"] for e in row["errors"])]
    if not all(math.isfinite(x) for x in numbers):
        return "not finite"
    if end > start:
        return "worse than the start"
    slack = LEFT_OF_COST * max(0.0, start - truth) + COST_SLACK * abs(truth)
    # Costs have noise of their own (fireflies): where the truth is known, being there counts, too.
    is_there = row["model_error"] == 0.0 and "vertices" not in row["kinds"] and all(e["left"] <= LEFT_OF_WAY for e in row["errors"])
    return "arrived" if end <= truth + slack or is_there else "not arrived"


def print_kinds(rows):
    """Where which unknowns arrive."""
    print(f"{'kind':20}{'scenes':>8}{'arrived':>9}{'median of its way left':>26}{'of exact models':>18}")
    for kind in sorted({k for r in rows for k in r["kinds"]}):
        of_kind = [r for r in rows if kind in r["kinds"]]
        left = [e["left"] for r in of_kind for e in r.get("errors", []) if e["kind"] == kind]
        exact = [e["left"] for r in of_kind if r["model_error"] == 0 for e in r.get("errors", []) if e["kind"] == kind]
        figures = "".join(f"{statistics.median(v):{w}.3g}" if v else " " * (w - 1) + "-" for v, w in ((left, 26), (exact, 18)))
        print(f"{kind:20}{len(of_kind):8d}{sum(r['outcome'] == 'arrived' for r in of_kind):9d}{figures}")


def print_row(row):
    costs = " / ".join(f"{row[k]:.3g}" if k in row else "-" for k in ("cost_start", "cost_end", "cost_truth"))
    print(f"{row['scene']:3d} {row['outcome']:20} {row['scalars']:4d} unknowns, {row['light']:11} {row['noise'][0]} {row['noise'][1]:<6g} "
          f"model error {row['model_error']:<5g} cost {costs}, {row.get('rounds', 0)} rounds, CPU {row.get('cpu_s', 0):.0f} s")
    for e in row.get("errors", []):
        print(f"      {e['name']:32} {e['left']:9.3g} of its way left, rms {e['rms']:.3g}")
    worst = max(row.get("deviations", {}).items(), key=lambda d: abs(d[1]), default=None)
    if worst:
        print(f"      farthest in standard errors: {worst[0]} {worst[1]:+.1f}")
    if row["outcome"] in ("failed", "no photos", "failed at the truth"):
        print("      " + row["messages"].strip().replace("\n", "\n      "))
    sys.stdout.flush()


def summarise(rows):
    summary = {"scenes": len(rows)}
    for outcome in sorted({r["outcome"] for r in rows}):
        summary[outcome] = sum(r["outcome"] == outcome for r in rows)
    ended = [r for r in rows if "cost_end" in r]
    summary["not worse than the start"] = sum(r["cost_end"] <= r["cost_start"] for r in ended)
    exact = [r for r in ended if r["model_error"] == 0.0 and r["deviations"]]
    if exact:
        summary["within 3 standard errors, of exact models"] = sum(all(abs(d) <= SIGMAS for d in r["deviations"].values()) for r in exact)
        summary["exact models with standard errors"] = len(exact)
        all_of = [d for r in exact for d in r["deviations"].values()]
        summary["rms deviation in standard errors"] = math.sqrt(sum(d * d for d in all_of) / len(all_of))
    return summary


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pathfit", type=Path, required=True)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="fits at a time")
    parser.add_argument("--threads", type=int, default=1, help="of each fit")
    parser.add_argument("--only", type=int, nargs="+", help="these scenes")
    parser.add_argument("--timeout", type=float, default=600.0, help="seconds of each fit")
    parser.add_argument("--keep", type=Path, help="configs, photos and runs stay here")
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    root = args.keep or Path(tempfile.mkdtemp(prefix="pathfit_random_"))
    rows = []
    try:
        with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
            for row in pool.map(lambda i: solve(args, i, root.absolute()), args.only or range(args.count)):
                rows.append(row)
                print_row(row)
                if args.out:
                    args.out.write_text(json.dumps({"summary": summarise(rows), "scenes": rows}, indent=1))
    finally:
        if not args.keep:
            shutil.rmtree(root, ignore_errors=True)
    print()
    print_kinds(rows)
    print()
    for name, number in summarise(rows).items():
        print(f"{name:45} {number:g}")


if __name__ == "__main__":
    main()
