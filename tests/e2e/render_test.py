"""Renders images and derivatives of a small scene and reads what was written.

Usage: render_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PATHFIT = pathlib.Path(sys.argv[1])
SCENE = pathlib.Path(sys.argv[2]) / "tests" / "scenes" / "moving_shadow.yaml"
SIZE = 24
MOVES, LIGHTS, OTHER = "square.vertices.x", "lamp.intensity", "floor.vertices.z"
ALL = "interior,primary,direct,pixel"


def read_exr(path):
    """Channels of a float32 image of scan lines, compressed by ZIP in blocks of 16: {name: rows}."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01", path
    at, header = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        header[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    assert header["compression"] == b"\x03", path
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, channels = [], header["channels"]
    while channels[0]:
        name, channels = channels.split(b"\0", 1)
        assert struct.unpack_from("<i", channels)[0] == 2, "float32"
        names.append(name.decode())
        channels = channels[16:]
    image = {name: [None] * height for name in names}
    for offset in struct.unpack_from(f"<{(height + 15) // 16}Q", data, at + 1):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = min(16, height - (y - y0))
        block = data[offset + 8:offset + 8 + size]
        if size < rows * width * 4 * len(names):
            packed = bytearray(zlib.decompress(block))
            for i in range(1, len(packed)):  # differences, even bytes first
                packed[i] = (packed[i - 1] + packed[i] - 128) & 255
            block = bytearray(len(packed))
            half = (len(packed) + 1) // 2
            block[0::2], block[1::2] = packed[:half], packed[half:]
        numbers = struct.unpack(f"<{rows * width * len(names)}f", block)
        for row in range(rows):
            for i, name in enumerate(names):
                start = (row * len(names) + i) * width
                image[name][y - y0 + row] = numbers[start:start + width]
    return image


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    return struct.unpack(">2I", data[16:24])


def flat(image):
    return [x for name in sorted(image) for row in image[name] for x in row]


class Render(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_e2e_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def render(self, name, derivatives, terms, form):
        """Files that were written, by name; all EXR are images of the sensor's size with finite values."""
        command = [PATHFIT, "render", SCENE, "-o", self.folder / name, "--terms", terms, "--form", form, "-q"]
        for derivative in derivatives:
            command += ["--derivative", derivative]
        for budget in ("sppe", "spp_direct", "spp_indirect", "spp_pixel"):
            command += ["--set", f"render.{budget}=8"]
        out = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
        self.assertEqual(out.returncode, 0, out.stderr)
        paths = [pathlib.Path(line) for line in out.stdout.splitlines()]
        stems = ["camera"] + ["camera_d_" + d for d in derivatives]
        self.assertEqual([p.name for p in paths],
                         [stem + tail for stem in stems for tail in (".exr", "_coverage.exr", ".png")])
        self.assertEqual(sorted(paths), sorted((self.folder / name).iterdir()))
        images = {}
        for path in paths:
            if path.suffix == ".png":
                width, height = png_size(path)
                if "_d_" in path.name:  # the key of the colours is below
                    self.assertGreaterEqual(width, SIZE, path)
                    self.assertGreater(height, SIZE, path)
                else:
                    self.assertEqual((width, height), (SIZE, SIZE), path)
                continue
            image = read_exr(path)
            self.assertEqual(sorted(image), ["Y"] if "coverage" in path.name else ["B", "G", "R"], path)
            for rows in image.values():
                self.assertEqual([len(row) for row in rows], [SIZE] * SIZE, path)
            self.assertTrue(all(map(math.isfinite, flat(image))), path)
            images[path.stem] = flat(image)
        return images

    def assert_equal(self, left, right):
        """To rounding: same seed, same samples."""
        scale = max(map(abs, left))
        self.assertGreater(scale, 0.0)
        self.assertLess(max(abs(a - b) for a, b in zip(left, right, strict=True)), 1e-6 * scale)

    def test_derivatives_asked_for_together_are_those_asked_for_alone(self):
        alone = self.render("alone", [MOVES], ALL, "material")
        lit = self.render("lit", [LIGHTS], ALL, "material")
        both = self.render("both", [MOVES, LIGHTS], ALL, "material")
        self.assertEqual(both["camera"], alone["camera"])
        self.assert_equal(both["camera_d_" + MOVES], alone["camera_d_" + MOVES])
        self.assert_equal(both["camera_d_" + LIGHTS], lit["camera_d_" + LIGHTS])
        # All light is the lamp's, 3 units of it in each channel.
        self.assert_equal(both["camera"], [3.0 * x for x in both["camera_d_" + LIGHTS]])
        self.assertEqual(set(both[f"camera_d_{LIGHTS}_coverage"]), {0.0})

    def test_samples_and_form_are_found_unless_given(self):
        def said(*options):
            out = subprocess.run(
                list(map(str, [PATHFIT, "render", SCENE, "-o", self.folder / "found", *options])),
                capture_output=True, text=True, timeout=600)
            self.assertEqual(out.returncode, 0, out.stderr)
            lines = [line for line in out.stderr.splitlines() if "derivatives seen by camera" in line]
            return lines[0].split("camera: ")[1] if lines else ""
        found = said("--derivative", MOVES)
        self.assertRegex(found, r"form (image|material), spp \d+, sppe [\d.]+, spp_direct [\d.]+")
        self.assertEqual(said("--derivative", MOVES, "--threads", 1), found)
        self.assertRegex(said("--derivative", MOVES, "--form", "image", "--set", "render.sppe=5"), r"form image, spp \d+, sppe 5,")
        self.assertEqual(said("--derivative", LIGHTS), "")

    def test_edges_of_two_things_that_move_share_samples_and_agree_in_the_mean(self):
        inner = [self.render("inner" + str(len(d)), d, "interior", "material") for d in ([MOVES], [MOVES, OTHER])]
        self.assert_equal(*(images["camera_d_" + MOVES] for images in inner))
        every = [self.render("all" + str(len(d)), d, ALL, "material") for d in ([MOVES], [MOVES, OTHER])]
        left, right = (images["camera_d_" + MOVES] for images in every)
        size = sum(map(abs, left))
        self.assertLess(abs(sum(left) - sum(right)), 0.01 * size)
        self.assertGreater(sum(abs(a - b) for a, b in zip(left, inner[0]["camera_d_" + MOVES])), 0.1 * size)

    def test_mistakes_have_their_status_and_what_limits_a_derivative_is_always_said(self):
        def run(*words):
            return subprocess.run([str(PATHFIT), *map(str, words)], capture_output=True, text=True, timeout=600)

        out = run("render", SCENE, "-o", self.folder / "none", "--derivative", "squre.vertices.x")
        self.assertEqual(out.returncode, 2, out.stderr)
        self.assertIn("squre", out.stderr)
        out = run("render", SCENE, "--derivative", MOVES, "--terms", "")
        self.assertEqual(out.returncode, 2)
        self.assertIn("--terms: '' has an empty part", out.stderr)
        out = run("gradcheck", SCENE, "--set", "render.terms=[]")
        self.assertEqual(out.returncode, 3)
        self.assertIn("render.terms", out.stderr)
        out = run("gradcheck", SCENE, "--step", "1e300", "-q")
        self.assertEqual(out.returncode, 7, out.stdout)
        self.assertRegex(out.stdout, r"NOT CHECKED.*square\.vertices\[0\]\.x")
        folding = ["--set", "scene.sensors.camera.distortion={k1: -9}"]
        out = run("check", SCENE, *folding)
        self.assertEqual(out.returncode, 4, out.stderr)
        self.assertRegex(out.stderr, r"moving_shadow\.yaml:\d+:\d+: camera 'camera': .*folds")
        glass = ["--set", "scene.materials.grey={model: mirror}"]
        quiet = run("render", SCENE, "-o", self.folder / "glass", "--derivative", MOVES, "--spp", 1, "-q", *glass)
        loud = run("render", SCENE, "-o", self.folder / "glass", "--derivative", MOVES, "--spp", 1, *glass)
        said = [line for line in loud.stderr.splitlines() if "mirror" in line or "not in" in line]
        self.assertTrue(said, loud.stderr)
        self.assertIn("not in the derivative", quiet.stderr)

    def test_gradcheck_sums_the_channel_that_changes_most(self):
        for channel, name in (("r", "red"), ("g", "green"), ("b", "blue")):
            out = subprocess.run([str(PATHFIT), "gradcheck", str(SCENE), "--params", "lamp.intensity." + channel, "--spp", "4",
                                  "--replicates", "4", "-q"], capture_output=True, text=True, timeout=600)
            self.assertEqual(out.returncode, 0, out.stderr)
            words = next(line for line in out.stdout.splitlines() if line.startswith("lamp.intensity")).split()
            self.assertEqual(words[2], name, out.stdout)
            self.assertGreater(abs(float(words[3])), 1.0, out.stdout)
            self.assertGreater(abs(float(words[5])), 1.0, out.stdout)

    def test_info_names_what_a_bug_report_needs(self):
        out = subprocess.run([str(PATHFIT), "info", "--json", "--threads", "3"], capture_output=True, text=True)
        self.assertEqual((out.returncode, out.stderr), (0, ""))
        info = json.loads(out.stdout)
        self.assertEqual(info["threads"], 3)
        self.assertIs(type(info["checks"]), bool)
        self.assertGreater(info["memory_bytes"], 1 << 28)
        for library in ("Embree", "Ceres", "OpenCV", "OpenEXR", "oneTBB", "OpenMesh", "OpenVDB"):
            self.assertRegex(info["libraries"][library], r"^\d+\.\d+")
        text = subprocess.run([str(PATHFIT), "info"], capture_output=True, text=True).stdout
        self.assertIn(info["cpu"], text)
        self.assertIn(info["version"], text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
