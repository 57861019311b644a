"""`init --sfm colmap`: with a stand-in for the program COLMAP, and with COLMAP itself where it is installed.

Usage: sfm_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PATHFIT = pathlib.Path(sys.argv[1]).absolute()
SOURCE = pathlib.Path(sys.argv[2]).absolute()
AXE = SOURCE / "data" / "axe"

# Notes its words; the mapper copies what is prepared, and SLOW waits for a signal.
STAND_IN = """#!/bin/sh
echo "$@" >> "$FAKE/words"
[ "$2" = -h ] && { cat "$FAKE/help"; exit 0; }
echo "said by $1"
[ -e "$FAKE/slow" ] && { echo started > "$FAKE/started"; exec sleep 60; }
[ "$1" = mapper ] || exit "$(cat "$FAKE/status")"
while [ "$1" != --output_path ]; do shift; done
cp -r "$FAKE"/models/. "$2"
[ -e "$2/0" ]
"""


class Sfm(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_sfm_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "models").mkdir()
        (self.folder / "help").write_text("--SiftExtraction.use_gpu arg (=1)\n")
        (self.folder / "status").write_text("0\n")
        (self.folder / "bin").mkdir()
        program = self.folder / "bin" / "colmap"
        program.write_text(STAND_IN)
        program.chmod(0o755)
        self.photos = self.folder / "set" / "images"
        shutil.copytree(AXE / "images", self.photos)
        self.log = self.folder / "set_colmap" / "colmap.log"

    def environment(self, path=None):
        return {**os.environ, "FAKE": str(self.folder), "PATH": path or f"{self.folder}/bin:{os.environ['PATH']}"}

    def init(self, *words, path=None):
        return subprocess.run([PATHFIT, "init", "set", "--sfm", "colmap", *map(str, words)], cwd=self.folder,
                              env=self.environment(path), capture_output=True, text=True, timeout=300)

    def write_model(self, name, photos):
        """The cameras of this many photos of the axe, as COLMAP would have found them."""
        model = self.folder / "models" / name
        subprocess.run([PATHFIT, "convert", "cameras", AXE / "transforms.json", model, "-q"], check=True,
                       capture_output=True)
        lines = (model / "images.txt").read_text().split("\n")
        (model / "images.txt").write_text("\n".join(lines[:1 + 2 * photos]) + "\n")

    def words(self):
        return [line.split() for line in (self.folder / "words").read_text().splitlines()]

    def test_runs_the_steps_and_drafts_a_config(self):
        self.write_model("0", 24)
        out = self.init("--masks", AXE / "masks", "--json")
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertEqual(json.loads(out.stdout)["camera_format"], "COLMAP model")
        self.assertIn("path: set_colmap/sparse/0", (self.folder / "set.yaml").read_text())
        steps = {line[0]: line for line in self.words()}
        self.assertEqual(list(steps), ["feature_extractor", "exhaustive_matcher", "mapper"])
        extractor = " ".join(steps["feature_extractor"])
        # One size, no EXIF: one camera.
        self.assertIn("--ImageReader.single_camera 1", extractor)
        self.assertIn("--SiftExtraction.use_gpu 0", extractor)
        self.assertIn("--SiftMatching.use_gpu 0", " ".join(steps["exhaustive_matcher"]))
        masks = sorted(p.name for p in (self.folder / "set_colmap" / "masks").iterdir())
        self.assertEqual(masks, sorted(p.name + ".png" for p in self.photos.iterdir()))
        for step in steps:
            self.assertIn(f"said by {step}", self.log.read_text())
        checked = subprocess.run([PATHFIT, "check", "set.yaml"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        again = self.init()
        self.assertEqual(again.returncode, 2)
        self.assertIn("--force", again.stderr)
        self.assertEqual(self.init("--force").returncode, 0)

    def test_keeps_a_calibration_and_newer_names_of_options(self):
        self.write_model("0", 24)
        (self.folder / "help").write_text("--FeatureExtraction.use_gpu arg (=1)\n")
        (self.folder / "lens.yaml").write_text(
            "image_width: 512\nimage_height: 342\ncamera_matrix: [[900, 0, 255.5], [0, 901, 170], [0, 0, 1]]\n"
            "distortion_coefficients: [0.01, 0.02, 0.03, 0.04, 0.05]\n")
        out = self.init("--calibration", "lens.yaml")
        self.assertEqual(out.returncode, 0, out.stderr)
        steps = {line[0]: " ".join(line) for line in self.words()}
        self.assertIn("--FeatureExtraction.use_gpu 0", steps["feature_extractor"])
        self.assertIn("FULL_OPENCV --ImageReader.camera_params 900,901,256,170.5,0.01,0.02,0.03,0.04,0.05,0,0,0",
                      steps["feature_extractor"])
        self.assertIn("--FeatureMatching.use_gpu 0", steps["exhaustive_matcher"])
        self.assertIn("--Mapper.ba_refine_focal_length 0", steps["mapper"])
        self.assertIn("calibration: lens.yaml", (self.folder / "set.yaml").read_text())

    def test_says_when_colmap_is_missing_fails_or_finds_nothing(self):
        missing = self.init(path=str(self.folder))
        self.assertEqual(missing.returncode, 4)
        self.assertIn("apt install colmap", missing.stderr)
        nothing = self.init()
        self.assertEqual(nothing.returncode, 4, nothing.stderr)
        self.assertIn("found no cameras", nothing.stderr)
        self.assertIn(str(self.log), nothing.stderr)
        (self.folder / "status").write_text("3\n")
        failed = self.init("--force")
        self.assertEqual(failed.returncode, 4)
        self.assertIn("feature_extractor failed (status 3)", failed.stderr)
        self.assertIn("said by feature_extractor", failed.stderr)
        self.assertFalse((self.folder / "set.yaml").exists())
        for photo in sorted(self.photos.iterdir())[2:]:
            photo.unlink()
        self.assertIn("at least 3", self.init("--force").stderr)
        given = self.init(AXE / "transforms.json")
        self.assertEqual(given.returncode, 2)

    def test_the_largest_of_several_models_is_used_and_said(self):
        self.write_model("0", 5)
        self.write_model("1", 12)
        out = self.init()
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn("12 of 24 photos", out.stderr)
        self.assertIn("several models", out.stderr)
        self.assertIn("12 pictures in", out.stderr)
        self.assertIn("set_colmap/sparse/1", (self.folder / "set.yaml").read_text())

    def test_photos_of_different_sizes_have_cameras_of_their_own(self):
        self.write_model("0", 24)
        odd = SOURCE / "data" / "axe" / "result.jpg"
        shutil.copy(odd, self.photos / "odd.jpg")
        out = self.init()
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn("a camera of its own", out.stderr)
        self.assertNotIn("single_camera", " ".join(self.words()[1]))

    def test_a_signal_ends_colmap_too(self):
        (self.folder / "slow").touch()
        process = subprocess.Popen([PATHFIT, "init", "set", "--sfm", "colmap"], cwd=self.folder,
                                   env=self.environment(), stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while not (self.folder / "started").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 75, said)
        self.assertFalse((self.folder / "set.yaml").exists())
        self.assertEqual(self.words()[-1][0], "feature_extractor")

    @unittest.skipUnless(shutil.which("colmap"), "COLMAP IS NOT INSTALLED: --sfm was tried with a stand-in only")
    def test_colmap_itself_answers(self):
        """Three photos are too few for a model: every step runs, and the reason is said."""
        for photo in sorted(self.photos.iterdir())[3:]:
            photo.unlink()
        (self.folder / "bin" / "colmap").unlink()
        out = self.init("--masks", AXE / "masks")
        self.assertEqual(out.returncode, 4, out.stderr)
        self.assertIn("found no cameras", out.stderr)
        log = self.log.read_text()
        self.assertIn("Features:", log)
        self.assertNotIn("unrecognised option", log)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
