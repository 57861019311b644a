"""Photos of a known scene by synth, fits of them, and what eval says of the fits.

Usage: truth_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

PATHFIT = pathlib.Path(sys.argv[1])
SOURCE = pathlib.Path(sys.argv[2])

# Two lamps beside a ball on a floor, each in photos of its own, by one camera and from a second place.
SCENE = """schema: 1
name: lamps
seed: 5
scene:
  geometry:
    ball: {primitive: {sphere: {subdivisions: 3}}, material: paint, normals: smooth, transform: {scale: 0.5}}
    floor: {primitive: {rectangle: {}}, material: grey, transform: {scale: 2, translate_m: [0, 0, -0.6]}}
  materials:
    paint: {model: diffuse, base_color: {constant: [0.7, 0.4, 0.2]}}
    grey: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}
  lights:
    left: {type: point, position_m: [-1.5, 0.5, 2], intensity: [6, 6, 6], photos: [a, side]}
    right: {type: point, position_m: [1.5, 0.2, 2], intensity: [5, 6, 7], photos: [b, side]}
    room: {type: constant, radiance: [0.1, 0.1, 0.1]}
  sensors:
    a: {size_px: [48, 40], fov_deg: 50, pose: {look_at: {origin_m: [0, 0, 3], target_m: [0, 0, 0]}}}
    b: {size_px: [48, 40], fov_deg: 50, exposure_ev: 1, pose: {look_at: {origin_m: [0, 0, 3], target_m: [0, 0, 0]}}}
    side: {size_px: [48, 40], fov_deg: 50, pose: {look_at: {origin_m: [1.5, 0, 2.5], target_m: [0, 0, 0]}}}
render: {spp: 256}
unknowns: {left.position: {}, left.intensity: {}, right.intensity: {}, paint.base_color: {}}
"""


def run(*arguments):
    return subprocess.run([PATHFIT, *map(str, arguments)], capture_output=True, text=True, timeout=600)


class Truth(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_truth_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "lamps.yaml").write_text(SCENE)

    def done(self, *arguments):
        result = run(*arguments)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
        return result

    def synth(self, *more):
        return json.loads(self.done("synth", self.folder / "lamps.yaml", "-o", self.folder / "set", "--json", *more).stdout)["sets"]

    def files(self, folder):
        return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*")
                if p.is_file() and p.name not in ("scene.yaml", "fit.yaml")}

    def test_a_fit_of_synthetic_photos_finds_the_truth(self):
        self.synth("--noise", "0.002")
        config = self.folder / "set" / "fit.yaml"
        text = config.read_text()
        self.assertIn('ev: {"b.exr": 1}', text)
        start = text.replace("intensity: [6, 6, 6]", "intensity: [3, 3, 3]").replace("[-1.5, 0.5, 2]", "[-1.3, 0.4, 1.8]")
        config.write_text(start.replace("[0.7, 0.4, 0.2]", "[0.5, 0.5, 0.5]"))
        self.done("check", config)
        self.done("fit", config, "-o", self.folder / "run", "--progress", "none", "--set", "stages.all.max_rounds=12")
        of_start = json.loads(self.done("eval", self.folder / "run", "--truth", self.folder / "set", "--json", "--stage", "start").stdout)
        result = json.loads(self.done("eval", self.folder / "run", "--truth", self.folder / "set", "--json").stdout)
        self.assertEqual(result["schema"], "pathfit-eval-1")
        left = {e["light"]: e for e in of_start["lights"]}["left"]
        self.assertGreater(left["position_m"], 0.25)
        left = {e["light"]: e for e in result["lights"]}["left"]
        self.assertLess(left["position_m"], 0.03)
        self.assertAlmostEqual(left["ratio_g"], 1.0, delta=0.03)
        colour = next(e for e in result["appearance"] if e["surface"] == "seen")
        self.assertLess(colour["rms_percent"], 2.0)
        self.assertGreater(result["relit"]["psnr_srgb_db"], of_start["relit"]["psnr_srgb_db"] + 6.0)
        self.assertGreater(result["fitted"]["psnr_srgb_db"], 35.0)
        self.assertTrue((self.folder / "run" / "evaluation.html").stat().st_size > 10000)
        self.done("render", self.folder / "run", "-o", self.folder / "pictures")
        # The lamp that is off in a photo has no part in it.
        again = self.done("render", self.folder / "lamps.yaml", "-o", self.folder / "pictures", "--views", "a,b", "--derivative",
                          "right.intensity.r", "--spp", "4", "--json")
        pictures = {pathlib.Path(p).name: pathlib.Path(p) for p in json.loads(again.stdout)["files"]}
        sizes = [pictures[f"{view}_d_right.intensity.r.png"].stat().st_size for view in "ab"]
        self.assertLess(sizes[0], 0.3 * sizes[1], "white all over")
        # Views are named in a list or one by one.
        for choice, views in ((["--views", "a,1"], "ab"), (["--sensor", "b", "--sensor", "a"], "ab"), (["--sensor", "b"], "b")):
            chosen = self.done("render", self.folder / "lamps.yaml", "-o", self.folder / "pictures", "--spp", "1", "--json", *choice)
            names = [pathlib.Path(p).name for p in json.loads(chosen.stdout)["files"]]
            self.assertEqual([n for n in names if n.endswith(".png")], [f"{view}.png" for view in views], choice)
        every = self.done("render", self.folder / "lamps.yaml", "-o", self.folder / "pictures", "--spp", "1", "--json", "--views", "all")
        self.assertGreater(len(json.loads(every.stdout)["files"]), 3 * 2)

    def test_the_same_seed_gives_the_same_files_and_copies_differ(self):
        errors = ["--noise", "0.01", "--pose-jitter", "1", "--exposure-jitter", "0.3", "--spp", "4"]
        self.synth(*errors)
        first = self.files(self.folder / "set")
        shutil.rmtree(self.folder / "set")
        sets = self.synth(*errors, "--copies", "2")
        self.assertEqual([pathlib.Path(s["folder"]).name for s in sets], ["1", "2"])
        one, two = (self.files(self.folder / "set" / n) for n in "12")
        self.assertEqual(first.keys(), one.keys())
        for name in ("photos/a.exr", "transforms.json", "truth/exposure.csv", "truth/ball.glb"):
            self.assertEqual(first[name], one[name], name)
            self.assertEqual(one[name] == two[name], name == "truth/ball.glb", name)
        fit = (self.folder / "set" / "1" / "fit.yaml").read_text()
        self.assertIn("exposure: {model: gain", fit)
        self.done("check", self.folder / "set" / "1" / "fit.yaml")

    def test_photos_are_written_as_they_are_rendered(self):
        process = subprocess.Popen([PATHFIT, "synth", self.folder / "lamps.yaml", "-o", self.folder / "set", "--spp", "20000"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 120
        while not (self.folder / "set" / "photos" / "a.exr").exists() and time.monotonic() < deadline:
            time.sleep(0.005)
        process.terminate()
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 75, said)
        self.assertIn("holds only some of the photos", said)
        self.assertFalse((self.folder / "set" / "photos" / "side.exr").exists())

    def test_photos_of_8_bits_are_read_again(self):
        self.synth("--format", "jpg", "--quality", "80", "--spp", "4")
        self.assertEqual((self.folder / "set" / "photos" / "a.jpg").read_bytes()[:2], b"\xff\xd8")
        self.done("check", self.folder / "set" / "fit.yaml")

    def test_unknown_exposures_stay_unknown(self):
        (self.folder / "lamps.yaml").write_text(SCENE.replace("unknowns: {", "unknowns: {exposure: {}, "))
        self.synth("--spp", "4")
        self.assertIn("exposure: {model: gain, ev:", (self.folder / "set" / "fit.yaml").read_text())
        self.done("check", self.folder / "set" / "fit.yaml")

    def test_wrong_input_is_refused(self):
        self.synth("--spp", "1")
        full = run("synth", self.folder / "lamps.yaml", "-o", self.folder / "set")
        self.assertEqual(full.returncode, 2)
        self.assertIn("is not empty", full.stderr)
        (self.folder / "bad.yaml").write_text(SCENE.replace("photos: [a, side]", "photos: [a, sid]"))
        bad = run("synth", self.folder / "bad.yaml", "-o", self.folder / "none")
        self.assertEqual(bad.returncode, 3)
        self.assertRegex(bad.stderr, r"bad.yaml:12:\d+: error: scene.lights.left.photos: no photo or sensor is called 'sid' \(did you mean 'side'\?\)")
        self.assertFalse((self.folder / "none").exists())
        self.assertEqual(run("eval", self.folder / "set").returncode, 4)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
