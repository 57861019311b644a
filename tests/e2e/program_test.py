"""Drives the program as a user does, on the reduced axe photographs.

Usage: program_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import base64
import csv
import json
import math
import os
import pathlib
import pty
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

PATHFIT = pathlib.Path(sys.argv[1])
SOURCE = pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "tests" / "support"))
from run_state import final_bytes  # noqa: E402

DEMO = SOURCE / "configs" / "axe_demo.yaml"
# The whole fit in seconds: two stages of few rounds with photographs of 48 pixels.
QUICK = ["--set", "input.split.validation=every 6"]
for stage, rounds, spp, max_spp in (("light", 2, 4, 8), ("all", 6, 16, 16)):  # fewer would keep the start
    QUICK += ["--set", f"stages.{stage}.max_rounds={rounds}", "--set", f"stages.{stage}.image_scale=0.25",
              "--set", f"stages.{stage}.spp={spp}", "--set", f"stages.{stage}.max_spp={max_spp}"]

SMALL = ["--set", "input.max_size_px=64"]


def run(*arguments, **options):
    return subprocess.run([PATHFIT, *map(str, arguments)], capture_output=True, text=True, timeout=600, **options)


def grey_png(width, height, value):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\0" + bytes([value]) * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def quaternion(rows):
    """w, x, y, z of a rotation."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    k = squares.index(max(squares))
    numbers = [[squares[0], h - f, c - g, d - b], [h - f, squares[1], b + d, c + g], [c - g, b + d, squares[2], f + h],
               [d - b, c + g, f + h, squares[3]]][k]
    return [n / math.hypot(*numbers) for n in numbers]


def fit(folder, *more):
    return run("fit", DEMO, "-o", folder, "--progress", "none", *QUICK, *more)


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A run from its start to its end in one go, which others are compared with."""
        top = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_e2e_straight_"))
        cls.addClassCleanup(shutil.rmtree, top)
        cls.straight = top / "run"
        start = time.monotonic()
        out = fit(cls.straight, "--threads", 2)
        assert out.returncode == 0, out.stderr
        cls.duration = time.monotonic() - start

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_e2e_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def assert_same_results(self, a, b):
        self.assert_same_bytes(final_bytes(a), final_bytes(b))

    def assert_same_bytes(self, left, right):  # assertEqual would look for what differs for hours
        self.assertEqual(left.keys(), right.keys())
        for name in left:
            self.assertTrue(left[name] == right[name], f"{name} differs")

    def check_report(self, run_folder):
        page = (run_folder / "report.html").read_text()
        self.assertIn("default-src 'none'", page)
        page, libraries = re.subn(r'<script id="three">.*?</script>', "", page, flags=re.S)
        self.assertEqual(libraries, 1)
        self.assertNotRegex(page, r'(src|href)="|url\(|@import|fetch\(|XMLHttp')
        data = json.loads(re.search(r'<script type="application/json" id="data">([^<]*)</script>', page)[1])
        rows = list(csv.DictReader((run_folder / "metrics.csv").read_text().splitlines()))
        self.assertEqual([r["step"] for r in data["history"]["rounds"]], [int(row["step"]) for row in rows])
        for figure in data["figures"]["round"]:
            self.assertIn(figure["key"], rows[0])
        self.assertEqual(data["status"], "finished")
        self.assertEqual(data["history"]["stages"][-1]["stage"], "all")
        self.assertTrue(data["history"]["parameters"] and data["config"] and data["resolved_config"])
        kinds = {"photo", "start", "result", "difference", "silhouette"}
        self.assertGreater(len(data["views"]), 8)
        for uri in [uri for view in data["views"] for uri in (view["pictures"][kind] for kind in kinds)]:
            self.assertEqual(base64.b64decode(uri.removeprefix("data:image/jpeg;base64,"))[:2], b"\xff\xd8")
        for uri in data["environment"].values():
            self.assertEqual(base64.b64decode(uri.removeprefix("data:image/png;base64,"))[:4], b"\x89PNG")
        if shutil.which("node"):
            scripts = [SOURCE / "app" / "output" / "report" / name for name in ("viewer.js", "report.js")]
            drawn = subprocess.run(["node", SOURCE / "tests" / "app" / "output" / "report_page_test.js", *scripts,
                                    run_folder / "report.html"], capture_output=True, text=True)
            self.assertEqual(drawn.returncode, 0, drawn.stderr)

    def test_no_report_and_fewer_pictures_when_the_config_says_so(self):
        out = fit(self.folder / "run", "--set", "output.report=false", "--set", "output.images.every_stage=false")
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertFalse((self.folder / "run" / "report.html").exists())
        large = {p.name for p in (self.folder / "run" / "images").glob("*/*_fit.png")}
        self.assertEqual(large, {"all_fit.png"})

    def test_fit_improves_held_out_views_and_leaves_a_complete_run(self):
        out = fit(self.folder / "run")
        self.assertEqual(out.returncode, 0, out.stderr)
        run_folder = pathlib.Path(out.stdout.strip())
        self.assertEqual(run_folder, self.folder / "run")
        record = json.loads((run_folder / "run.json").read_text())
        self.assertEqual(record["status"], "finished")
        psnr = [stage["psnr_srgb_val_db"] for stage in record["stages"]]
        self.assertEqual(len(psnr), 3)
        self.assertGreater(psnr[-1], psnr[0] + 1.0)
        rows = (run_folder / "metrics.csv").read_text().splitlines()
        self.assertEqual(len(rows), 9)
        self.check_report(run_folder)
        for name in ("config.yaml", "config.resolved.yaml", "log.txt", "result/axe.glb", "result/environment.hdr",
                     "result/cameras/transforms.json", "result/parameters.csv"):
            self.assertTrue((run_folder / name).exists(), name)
        again = run("fit", run_folder / "config.resolved.yaml", "-o", self.folder / "again", "--progress", "none")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assert_same_results(run_folder, self.folder / "again")
        rendered = run("render", run_folder, "--views", "0", "--spp", "4", "-o", self.folder / "renders")
        self.assertEqual(rendered.returncode, 0, rendered.stderr)
        for views, hint in (("0,nosuch", "nosuch"), ("IMG_8839", "did you mean 'IMG_8839.JPG'")):
            wrong = run("render", run_folder, "--views", views, "-o", self.folder / "wrong")
            self.assertEqual(wrong.returncode, 4)
            self.assertIn(hint, wrong.stderr)
        small = run("report", run_folder, "--max-size-mb", "0.1", "-o", self.folder / "small.html")
        self.assertRegex(small.stderr, r"the page has [\d.]+ MB, more than --max-size-mb 0.1")
        for path in rendered.stdout.split():
            self.assertTrue(pathlib.Path(path).exists(), path)
        self.check_what_can_be_made_of(run_folder)

    def check_what_can_be_made_of(self, run_folder):
        formats = {"glb": ["axe.glb", "scene.glb"], "obj": ["axe.obj", "axe.mtl", "axe.png"], "ply": ["axe.ply"],
                   "colmap": ["cameras.txt", "images.txt", "points3D.txt"], "transforms": ["transforms.json"],
                   "blender": ["blender_setup.py", "axe.glb", "environment.exr", "environment.hdr"]}
        out = run("export", run_folder, "--to", ",".join(formats), "--json")
        self.assertEqual(out.returncode, 0, out.stderr)
        files = json.loads(out.stdout)["files"]
        for name, expected in formats.items():
            folder = run_folder / "export" / name
            self.assertEqual(files[name], [str(folder / file) for file in expected])
            for file in files[name]:
                self.assertGreater(pathlib.Path(file).stat().st_size, 50, file)
        compile((run_folder / "export/blender/blender_setup.py").read_text(), "blender_setup.py", "exec")
        self.assertEqual((run_folder / "export/glb/axe.glb").read_bytes(), (run_folder / "result/axe.glb").read_bytes())
        start = run("export", run_folder, "--to", "ply", "--stage", "start", "-o", self.folder / "start")
        self.assertEqual(start.returncode, 0, start.stderr)
        fitted = (run_folder / "result/axe.ply").read_bytes()
        self.assertTrue((self.folder / "start/axe.ply").read_bytes() != fitted, "the start was kept")
        wrong = run("export", run_folder, "--to", "ply", "--stage", "nothing")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("they have start, light, all", wrong.stderr)
        light = run("export", run_folder, "--to", "ply,blender", "--stage", "light", "-o", self.folder / "light", "--json")
        self.assertEqual(light.returncode, 0, light.stderr)
        files = json.loads(light.stdout)["files"]
        self.assertEqual(files["ply"], [str(self.folder / "light/ply/axe.ply")], "a folder for each of several formats")
        self.assertTrue(pathlib.Path(files["ply"][0]).read_bytes() == (self.folder / "start/axe.ply").read_bytes())
        lights = {(folder / "environment.hdr").read_bytes() for folder in
                  (self.folder / "light/blender", run_folder / "export/blender")}
        self.assertEqual(len(lights), 2, "the first stage's light is not the last one's")

        # Its cameras are those of the photos' files, and give the same pictures in any format.
        out = run("init", SOURCE / "data/axe/images", run_folder / "result/cameras", "-o", self.folder / "again.yaml")
        self.assertEqual(out.returncode, 0, out.stderr)
        for name, cameras in (("own", "result/cameras/transforms.json"), ("colmap", "export/colmap")):
            out = run("render", run_folder, "--views", "1", "--spp", "4", "-o", self.folder / name, "--json",
                      "--cameras", run_folder / cameras)
            self.assertEqual(out.returncode, 0, out.stderr)
        own, again = ((self.folder / name / "IMG_8841_coverage.exr").read_bytes() for name in ("own", "colmap"))
        self.assertEqual(own, again)
        out = run("render", run_folder, "--views", "orbit:3", "--spp", "2", "-o", self.folder / "orbit",
                  "--env", run_folder / "result/environment.hdr")
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertEqual(len(list((self.folder / "orbit").glob("orbit_00?.png"))), 3)

        page = self.folder / "compare.html"
        out = run("compare", run_folder, self.folder / "again", "-o", page)
        self.assertEqual(out.returncode, 0, out.stderr)
        lines = out.stdout.splitlines()
        self.assertTrue(lines[1].startswith("run ") and lines[2].startswith("again "), out.stdout)
        self.assertIn("output.directory", out.stdout)
        self.assertNotIn("://", page.read_text().replace("http://www.w3.org/2000/svg", ""))
        self.assertEqual(len(json.loads(run("compare", run_folder, run_folder, "--json", "-o", page).stdout)["runs"]), 2)

    def test_any_number_of_threads_gives_the_same_bits(self):
        for threads in (1, 8):
            out = fit(self.folder / str(threads), "--threads", threads)
            self.assertEqual(out.returncode, 0, out.stderr)
            self.assert_same_results(self.folder / str(threads), self.straight)

    def test_killed_at_random_moments_and_resumed_gives_the_same_bits(self):
        chance = random.Random(5)
        command = [PATHFIT, "fit", DEMO, "-o", self.folder / "killed", "--progress", "none", *QUICK]
        for _ in range(40):
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                process.wait(timeout=chance.uniform(0.25, 0.7) * self.duration)
                break
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            finally:
                process.stderr.close()
            if (self.folder / "killed" / "run.json").exists():
                command = [PATHFIT, "resume", self.folder / "killed", "--progress", "none"]
        self.assertEqual(process.returncode, 0)
        self.assert_same_results(self.straight, self.folder / "killed")

    def test_damaged_checkpoints_are_found_and_an_older_one_is_said_to_be_continued(self):
        folder = self.folder / "run"
        shutil.copytree(self.straight, folder, symlinks=True)
        results = final_bytes(folder)
        older, newest = sorted((folder / "checkpoints").glob("state_*.cbor"))
        whole = {path: path.read_bytes() for path in (older, newest)}

        def flip_a_bit(path):
            at = random.Random(path.name).randrange(len(whole[path]))
            path.write_bytes(whole[path][:at] + bytes([whole[path][at] ^ 16]) + whole[path][at + 1:])

        flip_a_bit(newest)
        out = run("resume", folder, "--progress", "none")
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn(newest.name, out.stderr)
        warnings = json.loads((folder / "run.json").read_text())["warnings"]
        self.assertTrue(any(newest.name in text for text in warnings), warnings)
        self.assert_same_bytes(final_bytes(folder), results)
        for path in sorted((folder / "checkpoints").glob("state_*.cbor")):
            whole[path] = path.read_bytes()
            flip_a_bit(path)
        out = run("resume", folder, "--progress", "none")
        self.assertEqual(out.returncode, 4, out.stderr)
        for path in (folder / "checkpoints").glob("state_*.cbor"):
            self.assertIn(path.name, out.stderr)
        config = folder / "config.resolved.yaml"
        config.write_text(config.read_text() + "# a word more\n")
        out = run("resume", folder, "--progress", "none")
        self.assertEqual(out.returncode, 4, out.stderr)
        self.assertIn("config.resolved.yaml: has changed since the run began", out.stderr)

    def test_signals_stop_with_their_status_and_resume(self):
        for number, status in ((signal.SIGINT, 130), (signal.SIGTERM, 75), (signal.SIGHUP, 75)):
            folder = self.folder / str(int(number))
            process = subprocess.Popen([PATHFIT, "fit", DEMO, "-o", folder, "--progress", "none", *QUICK],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            deadline = time.monotonic() + 300
            while not list(folder.glob("checkpoints/state_*")) and time.monotonic() < deadline:
                time.sleep(0.02)
            process.send_signal(number)
            self.assertEqual(process.wait(timeout=60), status)
            self.assertEqual(json.loads((folder / "run.json").read_text())["status"], "stopped")
            self.assertEqual(run("resume", folder, "--progress", "none").returncode, 0)
            self.assert_same_results(self.straight, folder)

    def test_one_process_works_on_a_run(self):
        folder = self.folder / "run"
        process = subprocess.Popen([PATHFIT, "fit", DEMO, "-o", folder, "--progress", "none", *QUICK],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 300
        while not list(folder.glob("checkpoints/state_*")) and time.monotonic() < deadline:
            time.sleep(0.02)
        other = run("resume", folder, "--progress", "none")
        self.assertEqual(other.returncode, 4, other.stderr)
        self.assertIn("is being run by another process", other.stderr)
        process.kill()
        process.wait()
        # The lock has died with its process.
        self.assertEqual(run("resume", folder, "--progress", "none").returncode, 0)
        log = (folder / "log.txt").read_text()
        self.assertRegex(log, r"debug stage=all it=6/6 ")
        self.assertRegex(log, r"debug stage=all end=true ")
        record = json.loads((folder / "run.json").read_text())
        said = re.search(r"all stages done; 8 rounds in (?:(\d+) min )?([\d.]+) s; (.*)", log)
        self.assertAlmostEqual(60 * int(said[1] or 0) + float(said[2]), record["wall_s"], delta=0.51, msg="one time")
        self.assertRegex(said[3], rf"^PSNR of held-out photos [\d.]+ -> [\d.]+ dB \(sRGB\), mask IoU [\d.]+ -> [\d.]+; report: {folder}/report.html$")

    def test_a_full_disk_stops_with_the_last_good_state(self):
        disk = self.folder / "disk"
        disk.mkdir()
        # A disk of its own in a name space of its own, filled when the fit has begun; then there is room again.
        script = f"""
            mount -t tmpfs -o size=64m none {disk} || exit 99
            {PATHFIT} fit "$@" -o {disk}/run --progress none & fitting=$!
            while [ ! -e {disk}/run/checkpoints/state_000001.cbor ]; do sleep 0.05; kill -0 $fitting || exit 98; done
            head -c 100m /dev/zero > {disk}/filling
            wait $fitting; echo stopped=$?
            rm {disk}/filling
            {PATHFIT} resume {disk}/run --progress none; echo resumed=$?
        """
        out = subprocess.run(["unshare", "--map-root-user", "--mount", "bash", "-c", script, "-", DEMO, *QUICK],
                             capture_output=True, text=True, timeout=600)
        if "stopped=" not in out.stdout:
            self.skipTest("no name spaces here: " + out.stderr)
        self.assertIn("stopped=75", out.stdout, out.stderr)
        self.assertIn("resumed=0", out.stdout, out.stderr)
        self.assertRegex(out.stderr, f"the disk is full; make room, then continue with: pathfit resume {disk}/run")

    def test_wrong_input_is_refused_with_its_place_and_nothing_is_written(self):
        def refused(status, pattern, *arguments):
            out = run(*arguments, "-o", self.folder / "none")
            self.assertEqual(out.returncode, status, out.stderr)
            self.assertRegex(out.stderr, pattern)
            self.assertEqual(out.stdout, "")
            self.assertFalse((self.folder / "none").exists())

        text = DEMO.read_text().replace("../data", str(SOURCE / "data"))
        config = self.folder / "wrong.yaml"
        config.write_text(text.replace("max_size_px", "max_size_pix").replace("model: gain", "model: 3"))
        refused(3, r"wrong\.yaml:\d+:\d+: error: .*max_size_pix.*did you mean 'max_size_px'(.|\n)*2 errors", "fit", config)
        config.write_text(text.replace("/images", "/no_images"))
        refused(4, "no_images", "fit", config)
        config.write_text(text.replace("axe/masks", "axe/images"))
        refused(4, r"IMG_8839\.JPG", "fit", config)
        config.write_text(text.replace("transforms.json", "none.json"))
        refused(4, r"none\.json", "fit", config)
        (self.folder / "nan.obj").write_text("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n")
        config.write_text(re.sub(r"file: \S+init_hull\.ply", f"file: {self.folder}/nan.obj", text))
        refused(4, r"nan\.obj:2", "fit", config)
        refused(2, "fit", "fti", config)
        config.write_text(text)
        out = run("fit", config, "-o", self.folder / "none", "--set", "solver.max_memory=1 MiB")
        self.assertEqual(out.returncode, 8, out.stderr)
        self.assertIn("memory", out.stderr)

    def test_init_writes_a_config_that_check_accepts_and_never_overwrites(self):
        config = self.folder / "axe.yaml"
        ready = run("init", SOURCE / "data" / "axe", cwd=self.folder)
        self.assertEqual(ready.returncode, 0, ready.stderr)
        self.assertEqual(ready.stdout.strip(), str(config))
        self.assertIn("frame: camera", config.read_text(), "it stood on a turntable")
        checked = run("check", config, *SMALL)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertNotIn("warning", checked.stderr)
        config.write_text("mine")
        again = run("init", SOURCE / "data" / "axe", cwd=self.folder)
        self.assertEqual(again.returncode, 2)
        self.assertEqual(config.read_text(), "mine")
        forced = run("init", SOURCE / "data" / "axe", "--force", "--json", "--surface", "shiny", cwd=self.folder)
        self.assertEqual(json.loads(forced.stdout)["surface"], "shiny")
        self.assertIn("surface.roughness: {}", config.read_text())
        self.assertEqual(json.loads(forced.stdout)["masks"], 24)
        gone = run("init", SOURCE / "data" / "axe", "--mesh", "gone.ply", "-o", "b.yaml", cwd=self.folder)
        self.assertEqual(gone.returncode, 4)
        self.assertFalse((self.folder / "b.yaml").exists())
        nothing = run("init", self.folder)
        self.assertEqual(nothing.returncode, 4)
        self.assertIn("no cameras were found", nothing.stderr)

    def test_init_drafts_photometric_stereo(self):
        photos = SOURCE / "data" / "cat" / "photos"
        lamps = SOURCE / "data" / "cat" / "light_directions.txt"
        drafted = run("init", photos, "-o", "cat.yaml", "--json", cwd=self.folder)  # lamps lie above the photos
        self.assertEqual(drafted.returncode, 0, drafted.stderr)
        result = json.loads(drafted.stdout)
        self.assertEqual((result["light"], result["photos"], result["masks"]), ("lamps", 12, 12))
        self.assertTrue((self.folder / "cat_start.ply").exists())
        checked = run("check", "cat.yaml", "--set", "input.max_size_px=64", cwd=self.folder)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        for more in (["--sfm", "colmap"], ["--light", "flash"], ["--whole-photos"], ["--ball", photos]):
            refused = run("init", photos, "--lamps", lamps, "-o", "b.yaml", *more, cwd=self.folder)
            self.assertEqual(refused.returncode, 2, refused.stderr)
        empty = run("init", SOURCE / "data" / "axe" / "images", "--lamps", lamps, "-o", "b.yaml", cwd=self.folder)
        self.assertEqual(empty.returncode, 4, empty.stderr)
        self.assertIn("has 12 lamps, but", empty.stderr)
        again = run("init", photos, "-o", "cat.yaml", cwd=self.folder)
        self.assertEqual(again.returncode, 2, again.stderr)

    def test_init_makes_masks_where_there_are_none(self):
        photos = self.folder / "set"
        shutil.copytree(SOURCE / "data/axe/images", photos / "images")
        cameras = json.loads((SOURCE / "data/axe/transforms.json").read_text())
        for frame in cameras["frames"]:
            del frame["mask_path"]
        (photos / "transforms.json").write_text(json.dumps(cameras))
        config, masks = self.folder / "set.yaml", self.folder / "set_masks"
        made = run("init", photos, "--json", cwd=self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertGreater(json.loads(made.stdout)["mask_agreement"], 0.9)
        self.assertEqual(len(list(masks.glob("*.png"))), 24)
        self.assertIn("visual_hull", config.read_text())
        checked = run("check", config, *SMALL, cwd=self.folder)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertNotIn("warning", checked.stderr)
        config.unlink()
        again = run("init", photos, cwd=self.folder)
        self.assertEqual(again.returncode, 2)
        self.assertIn("set_masks exists", again.stderr)
        whole = run("init", photos, "--whole-photos", cwd=self.folder)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        self.assertIn("sphere", config.read_text())

    def test_init_starts_from_sparse_points_where_colours_tell_nothing(self):
        photos, model = self.folder / "set" / "images", self.folder / "set" / "sparse" / "0"
        photos.mkdir(parents=True)
        model.mkdir(parents=True)
        (model / "cameras.txt").write_text("1 PINHOLE 64 64 96 96 32 32\n")
        images, golden = "", math.pi * (3 - math.sqrt(5))
        for i in range(16):  # cameras all around, 4 units from the middle
            y = 1 - (2 * i + 1) / 16
            away = [math.sqrt(1 - y * y) * math.cos(golden * i), y, math.sqrt(1 - y * y) * math.sin(golden * i)]
            forward = [-a for a in away]
            right = [forward[2], 0, -forward[0]]
            length = math.hypot(*right)
            right = [r / length for r in right]
            down = [forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2],
                    forward[0] * right[1] - forward[1] * right[0]]
            images += f"{i + 1} {' '.join(map(str, quaternion([right, down, forward])))} 0 0 4 1 {i:02}.png\n\n"
            (photos / f"{i:02}.png").write_bytes(grey_png(64, 64, 90 + i))
        (model / "images.txt").write_text(images)
        points = ""
        for i in range(1500):  # on a ball of radius .7
            y = 1 - (2 * i + 1) / 1500
            r = .7 * math.sqrt(1 - y * y)
            points += f"{i} {r * math.cos(golden * i)} {.7 * y} {r * math.sin(golden * i)} 9 9 9 0.1\n"
        (model / "points3D.txt").write_text(points)
        made = run("init", self.folder / "set", "--json", cwd=self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertTrue(json.loads(made.stdout)["start_of_points"], made.stderr)
        self.assertEqual(len(list((self.folder / "set_region").glob("*.png"))), 16)
        self.assertTrue((self.folder / "set_start.ply").exists())
        checked = run("check", "set.yaml", cwd=self.folder)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("black means no data", checked.stderr + checked.stdout)
        (self.folder / "set.yaml").unlink()
        shutil.rmtree(self.folder / "set_region")
        (self.folder / "set_start.ply").unlink()
        (model / "points3D.txt").write_text(points + "7 1 2 nan 9 9 9 0.1\n")
        broken = run("init", self.folder / "set", cwd=self.folder)
        self.assertEqual(broken.returncode, 0, broken.stderr)
        self.assertRegex(broken.stderr, "sparse points of the cameras are of no use: .*points3D.txt:1501")
        self.assertIn("sphere", (self.folder / "set.yaml").read_text())

    def test_check_and_fit_refuse_the_same_memory(self):
        limits = ["--set", "input.max_size_px=64", "--max-memory", "50MiB"]
        said = [run("check", DEMO, "-o", self.folder / "page.html", *limits),
                run("fit", DEMO, "-o", self.folder / "run", "--progress", "none", *limits)]
        for out in said:
            self.assertEqual(out.returncode, 8, out.stderr)
            self.assertRegex(out.stderr, r"needs about +[\d.]+ MB, the limit is +52.4 MB(.|\n)*scene and photos as loaded")
        self.assertFalse((self.folder / "run").exists())
        done = fit(self.folder / "run", "--set", "stages.light.max_rounds=1", "--stop-after", "light")
        self.assertEqual(done.returncode, 0, done.stderr)
        again = run("resume", self.folder / "run", "--progress", "none", "--max-memory", "50MiB")
        self.assertEqual(again.returncode, 8, again.stderr)
        self.assertRegex(again.stderr, r"the limit is +52.4 MB(.|\n)*scene and photos as loaded")

    def test_too_little_memory_ends_with_its_status(self):
        config = self.folder / "axe.yaml"
        config.write_text(DEMO.read_text().replace("../data", str(SOURCE / "data")))
        # Loading the program's libraries, starting its threads, tracing: all of it may fail, and nothing may hang.
        for megabytes in (400, 450, 500, 600, 700):
            out = subprocess.run(["sh", "-c", f'ulimit -v {megabytes}000; exec "$@"', "sh", PATHFIT, "check", config, "-o",
                                  self.folder / "check.html"], capture_output=True, text=True, timeout=120)
            self.assertIn(out.returncode, (0, 8, 127), f"{megabytes} MB: {out.stderr}")
            if out.returncode == 8:
                self.assertRegex(out.stderr, "memory")

    def test_init_asks_at_a_terminal_what_photos_do_not_tell(self):
        photos = self.folder / "photos"
        shutil.copytree(SOURCE / "data/axe/images", photos / "images")
        cameras = json.loads((SOURCE / "data/axe/transforms.json").read_text())
        cameras["frames"] = cameras["frames"][::3]
        for i, frame in enumerate(cameras["frames"]):
            del frame["mask_path"]
            # A background that changes.
            (photos / frame["file_path"]).write_bytes(grey_png(frame["w"], frame["h"], 60 + 40 * (i % 5)))
        (photos / "transforms.json").write_text(json.dumps(cameras))
        config = self.folder / "photos.yaml"

        def answered(line):
            config.unlink(missing_ok=True)
            ours, theirs = pty.openpty()
            process = subprocess.Popen([PATHFIT, "init", photos, "-o", config, "--whole-photos"], stdin=theirs, stdout=subprocess.DEVNULL,
                                       stderr=theirs)
            os.write(ours, line)
            self.assertEqual(process.wait(timeout=120), 0)
            said = os.read(ours, 1 << 20).decode()
            os.close(ours)
            os.close(theirs)
            self.assertIn("Did the light stand still", said)
            return config.read_text()

        self.assertIn("frame: camera", answered(b"c\n").split("surroundings:")[1])
        self.assertIn("frame: world", answered(b"W\n").split("surroundings:")[1])
        self.assertIn("frame: world", answered(b"\n").split("surroundings:")[1])
        self.assertIn("flash.intensity: {}", answered(b"flash\n"))
        config.unlink()
        unasked = run("init", photos, "-o", config, "--whole-photos")
        self.assertNotIn("Did the light", unasked.stderr)
        self.assertIn("the background changes from photo to photo", unasked.stderr)
        for light, part in ("camera", "frame: camera, visible"), ("flash", "flash: {type: point, frame: camera"):
            told = run("init", photos, "-o", config, "--force", "--light", light, "--json", "--whole-photos")
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertEqual(json.loads(told.stdout)["light"], light)
            self.assertIn(part, config.read_text())
            self.assertEqual(run("check", config, "-o", self.folder / "check.html", *SMALL).returncode, 0)

    def test_hopeless_input_is_refused_or_warned_of(self):
        away = run("check", DEMO, "--set", "scene.geometry.axe.transform={translate_m: [50, 0, 0]}")
        self.assertEqual(away.returncode, 4)
        self.assertIn("the object is in no fitted photo", away.stderr)
        eaten = fit(self.folder / "run", "--set", "input.masks.erode_px=100")
        self.assertEqual(eaten.returncode, 3)
        self.assertIn("leave nothing of any mask", eaten.stderr)
        self.assertFalse((self.folder / "run").exists())
        inverted = run("check", DEMO, "--json", "--set", "input.masks.invert=true")
        self.assertEqual(inverted.returncode, 0)
        self.assertIn("the masks look inverted", json.loads(inverted.stdout)["warnings"][0])

    def test_help_goes_to_stdout_with_status_zero(self):
        out = run("--help")
        self.assertEqual((out.returncode, out.stderr), (0, ""))
        self.assertIn("gradcheck", out.stdout)

    def test_gradcheck_says_when_the_difference_drowns(self):
        faint = run("gradcheck", SOURCE / "tests" / "scenes" / "gradcheck_ball.yaml", "--params", "ball.vertices.y", "--json",
                    "--set", "gradcheck.step=1e-7", "--set", "gradcheck.spp=2", "--set", "gradcheck.replicates=8")
        self.assertRegex(faint.stdout, r'"verdict": *"inconclusive"', faint.stderr)
        self.assertIn("1 of 1 comparisons are inconclusive: the finite difference drowns", faint.stderr)

    def test_gradcheck_says_when_the_step_is_too_large(self):
        wide = run("gradcheck", SOURCE / "tests" / "scenes" / "moving_shadow.yaml", "--json", "--set", "gradcheck.step=0.4")
        self.assertRegex(wide.stdout, r'"verdict": *"inconclusive"', wide.stderr)
        self.assertIn("at half the step the finite difference is another; lower --step", wide.stderr)

    def test_gradcheck_agrees_and_reports_a_wrong_derivative(self):
        scene = SOURCE / "tests" / "scenes" / "gradcheck_ball.yaml"
        good = run("gradcheck", scene, "--params", "ball.vertices.y", "--params", "sky.texels", "--json", "-q")
        self.assertEqual(good.returncode, 0, good.stdout)
        self.assertTrue(all(row["signal_to_noise"] > 5 for row in json.loads(good.stdout)["rows"]))
        shadow = SOURCE / "tests" / "scenes" / "moving_shadow.yaml"
        good = run("gradcheck", shadow, "--json", "-q")
        self.assertEqual(good.returncode, 0, good.stdout)
        lamp = run("gradcheck", SOURCE / "tests" / "scenes" / "rectangle_light.yaml", "--json", "-q")
        self.assertEqual(lamp.returncode, 0, lamp.stdout)
        # Without the terms of moving edges the derivative is wrong, and the check must say so.
        for terms in ("[interior]", "[interior, primary]"):
            bad = run("gradcheck", shadow, "--json", "-q", "--set", f"render.terms={terms}")
            self.assertEqual(bad.returncode, 7, bad.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
