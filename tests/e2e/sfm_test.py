"""`init --sfm colmap` and `init VIDEO`: with stand-ins for the programs COLMAP and ffmpeg, and with these themselves
where they are installed.

Usage: sfm_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import json
import os
import pathlib
import re
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


# A film of ten pictures a second, of which every fifth is sharp: frames are those of the masks, in their order.
STAND_IN_FFMPEG = """#!/bin/sh
echo "$(basename "$0") $@" >> "$FAKE/words"
[ -e "$FAKE/no_video" ] && { echo "moov atom not found" >&2; exit 1; }
case "$0" in *ffprobe) cat "$FAKE/probe"; exit 0;; esac
for last; do :; done
[ "$last" = - ] && { cat "$FAKE/blur"; exit 0; }
i=0
for picture in "$FAKE"/pictures/*; do i=$((i + 1)); cp "$picture" "$(printf "$last" $i)"; done
"""
FRAMES = 24


class Sfm(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_sfm_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "models").mkdir()
        (self.folder / "help").write_text("--SiftExtraction.use_gpu arg (=1)\n")
        (self.folder / "status").write_text("0\n")
        (self.folder / "bin").mkdir()
        for name, text in (("colmap", STAND_IN), ("ffmpeg", STAND_IN_FFMPEG), ("ffprobe", STAND_IN_FFMPEG)):
            program = self.folder / "bin" / name
            program.write_text(text)
            program.chmod(0o755)
        self.photos = self.folder / "set" / "images"
        shutil.copytree(AXE / "images", self.photos)
        self.log = self.folder / "set_colmap" / "colmap.log"

    def environment(self, path=None):
        return {**os.environ, "FAKE": str(self.folder), "PATH": path or f"{self.folder}/bin:{os.environ['PATH']}"}

    def run_init(self, *words, path=None):
        return subprocess.run([PATHFIT, "init", *map(str, words)], cwd=self.folder, env=self.environment(path),
                              capture_output=True, text=True, timeout=300)

    def init(self, *words, path=None):
        return self.run_init("set", "--sfm", "colmap", *words, path=path)

    def write_video(self):
        """What the stand-in says of set.mp4, and the model of its frames."""
        (self.folder / "set.mp4").write_text("a film")
        (self.folder / "probe").write_text(
            "width=512\nheight=342\ncolor_space=unknown\ncolor_transfer=bt709\navg_frame_rate=10/1\n"
            "duration=N/A\nduration=12.0\n")
        (self.folder / "blur").write_text("".join(
            f"frame:{i} pts:{i} pts_time:{i / 10}\nlavfi.blur={3.5 if i % 5 == 2 else 9.0}\n"
            for i in range(5 * FRAMES)))
        shutil.copytree(AXE / "masks", self.folder / "pictures")
        self.write_model("0", FRAMES)
        images = self.folder / "models" / "0" / "images.txt"
        lines = images.read_text().split("\n")
        for i in range(FRAMES):
            words = lines[2 * i + 1].split()
            lines[2 * i + 1] = " ".join(words[:-1] + [f"frame_{i + 1:04d}.png"])
        images.write_text("\n".join(lines))

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

    def test_a_video_s_sharpest_frames_are_the_photos(self):
        self.write_video()
        out = self.run_init("set.mp4", "--frames", FRAMES, "--whole-photos", "--light", "world", "--json")
        self.assertEqual(out.returncode, 0, out.stderr)
        result = json.loads(out.stdout)
        self.assertEqual((result["name"], result["photos"]), ("set", FRAMES))
        frames = self.folder / "set_frames"
        self.assertEqual(sorted(p.name for p in frames.iterdir()), [f"frame_{i + 1:04d}.png" for i in range(FRAMES)])
        self.assertFalse((self.folder / "set_frames.part").exists())
        text = (self.folder / "set.yaml").read_text()
        self.assertIn("images: set_frames", text)
        self.assertIn("path: set_colmap/sparse/0", text)
        words = (self.folder / "words").read_text().splitlines()
        self.assertEqual([line.split()[0] for line in words[:3]], ["ffprobe", "ffmpeg", "ffmpeg"])
        self.assertIn("fps=10.0", words[1])
        chosen = [int(n) for n in re.findall(r"eq\(n\\,(\d+)\)", words[2])]
        self.assertEqual(chosen, [5 * i + 2 for i in range(FRAMES)])
        self.assertIn("in_color_matrix=bt601", words[2])
        self.assertEqual(self.run_init("set.mp4", "--whole-photos").returncode, 2)
        (frames / "note.txt").write_text("mine")
        for picture in sorted((self.folder / "pictures").iterdir())[12:]:
            picture.unlink()
        out = self.run_init("set.mp4", "--frames", 12, "--whole-photos", "--light", "world", "--force")
        self.assertIn("12 frames of", out.stderr)
        self.assertEqual(len(list(frames.glob("*.png"))), 12)
        self.assertTrue((frames / "note.txt").exists())

    def test_says_when_a_video_cannot_be_read(self):
        self.write_video()
        self.assertIn("apt install ffmpeg", self.run_init("set.mp4", path=str(self.folder)).stderr)
        out = self.run_init("set", "--frames", 12)
        self.assertEqual(out.returncode, 2)
        self.assertIn("--frames are those of a video", out.stderr)
        self.assertEqual(self.run_init("set.mp4", "cameras.yaml").returncode, 2)
        (self.folder / "probe").write_text("width=512\nheight=342\navg_frame_rate=0/0\nduration=N/A\n")
        out = self.run_init("set.mp4")
        self.assertEqual(out.returncode, 4)
        self.assertIn("no moving pictures of known length", out.stderr)
        (self.folder / "no_video").touch()
        out = self.run_init("set.mp4", "--force")
        self.assertEqual(out.returncode, 4)
        self.assertIn("moov atom not found", out.stderr)
        self.assertFalse((self.folder / "set_frames").exists())

    @unittest.skipUnless(shutil.which("ffmpeg"), "FFMPEG IS NOT INSTALLED: init VIDEO was tried with a stand-in only")
    def test_ffmpeg_itself_answers(self):
        """Each photo stands for half a second and is sharp for a fifth of it."""
        self.write_video()
        for name in ("ffmpeg", "ffprobe"):
            (self.folder / "bin" / name).unlink()
        for i, photo in enumerate(sorted(self.photos.iterdir())):
            photo.rename(self.photos / f"{i:02d}.jpg")
        blur = "fps=10,gblur=sigma=4:enable='not(eq(mod(n,5),3))',format=yuv420p"
        film = self.folder / "100 %d film's.mp4"
        subprocess.run(["ffmpeg", "-v", "error", "-framerate", "2", "-i", self.photos / "%02d.jpg", "-vf", blur,
                        "-c:v", "mpeg4", "-q:v", "2", film], check=True)
        out = self.run_init(film.name, "--frames", FRAMES, "--whole-photos", "--light", "world", "-o", "set.yaml")
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn(f"{FRAMES} frames of", out.stderr)
        frames = sorted((self.folder / "set_frames").iterdir())
        self.assertEqual(len(frames), FRAMES)
        for i in (0, 11, FRAMES - 1):
            likeness = subprocess.run(
                ["ffmpeg", "-i", frames[i], "-i", self.photos / f"{i:02d}.jpg", "-lavfi", "[0][1]psnr", "-f", "null", "-"],
                capture_output=True, text=True).stderr
            self.assertGreater(float(re.search(r"average:([\d.]+)", likeness)[1]), 32, likeness)

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
