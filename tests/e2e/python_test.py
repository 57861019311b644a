"""The Python module: pictures, derivatives and fits are those of the program.

Usage: python_test.py PATHFIT SOURCE_DIR MODULE_FOLDER. Unittest output; exits 1 if anything fails.
"""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest
from unittest import mock

import numpy as np

PATHFIT, SOURCE = (pathlib.Path(p) for p in sys.argv[1:3])
sys.path.insert(0, sys.argv[3])
import pathfit  # noqa: E402

SCENE = """schema: 1
name: lit
seed: 5
scene:
  geometry:
    ball: {primitive: {sphere: {subdivisions: 2}}, material: paint, transform: {scale: 0.5}}
    floor: {primitive: {rectangle: {}}, material: grey, transform: {scale: 2, translate_m: [0, 0, -0.6]}}
  materials:
    paint: {model: diffuse, base_color: {constant: [0.7, 0.4, 0.2]}}
    grey: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}
  lights:
    lamp: {type: point, position_m: [-1.5, 0.5, 2], intensity: [6, 6, 6]}
  sensors:
    front: {size_px: [24, 20], fov_deg: 50, pose: {look_at: {origin_m: [0, 0, 3], target_m: [0, 0, 0]}}}
    side: {size_px: [24, 20], fov_deg: 50, pose: {look_at: {origin_m: [1.5, 0, 2.5], target_m: [0, 0, 0]}}}
render: {spp: 16}
unknowns: {lamp.intensity: {}, paint.base_color: {}}
"""


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="pathfit_python_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.config = cls.folder / "lit.yaml"
        cls.config.write_text(SCENE)

    def program(self, *arguments):
        done = subprocess.run([PATHFIT, *map(str, arguments)], capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_pictures_depend_on_seed_and_samples_alone(self):
        one = pathfit.Scene(self.config, threads=1)
        two = pathfit.Scene(str(self.config), overrides={"render.spp": 32}, threads=2)
        self.assertEqual(one.views, ["front", "side"])
        picture = one.render("side", spp=32)
        self.assertEqual((picture.shape, picture.dtype), ((20, 24, 4), np.float64))
        self.assertTrue(np.array_equal(picture, two.render(1)))
        self.assertFalse(np.array_equal(picture, one.render("side", spp=32, seed=6)))
        self.assertGreater(picture[10, 12, 3], 0.9)

    def test_three_ways_to_the_same_derivative(self):
        scene = pathfit.Scene(self.config)
        parameters = scene.parameters(["ball.vertices", "lamp.intensity", "camera.position"])
        self.assertEqual(len(parameters), 162 * 3 + 3 + 6)
        self.assertEqual(parameters.groups[1], {"name": "lamp.intensity", "first": 486, "shape": (1, 3)})
        self.assertEqual(parameters.name_of(4), "ball.vertices[1].y")
        jacobian = scene.jacobian("front", parameters)
        self.assertEqual(jacobian.shape, (20 * 24 * 4, len(parameters)))
        self.assertLess(jacobian.nnz, jacobian.shape[0] * jacobian.shape[1] / 4)
        along = np.zeros(len(parameters))
        along[0:486:3] = 1
        alone = scene.parameters(["ball.vertices"])
        image = (scene.jacobian("front", alone) @ along[:486]).reshape(20, 24, 4)
        self.assertGreater(abs(image).max(), 0.1)
        np.testing.assert_allclose(image, scene.derivative("front", "ball.vertices.x"), atol=2e-5 * abs(image).max())
        weights = np.random.default_rng(1).normal(size=(20, 24, 4))
        gradient = scene.gradient("front", parameters, weights)
        np.testing.assert_allclose(gradient, jacobian.T @ weights.reshape(-1), atol=1e-5 * abs(gradient).max())
        self.assertEqual(scene.not_in_the_derivative(parameters), [])

    def test_differences_agree(self):
        scene = pathfit.Scene(self.config)
        parameters = scene.parameters(["lamp.intensity"])
        start = scene.values(parameters)
        np.testing.assert_array_equal(start, [6, 6, 6])
        before = scene.render(0, spp=64)
        derivative = scene.derivative(0, "lamp.intensity", spp=64)
        scene.set_values(parameters, start + 0.5)
        np.testing.assert_allclose(scene.render(0, spp=64) - before, 0.5 * derivative, atol=1e-9)

    def test_wrong_input_has_the_program_s_words(self):
        with self.assertRaisesRegex(pathfit.ConfigError, r"render\.spp"):
            pathfit.Scene(self.config, overrides={"render.spp": -1})
        with self.assertRaisesRegex(pathfit.ConfigError, "cannot be opened"):
            pathfit.Scene(self.folder / "nothing.yaml")
        self.config.with_name("no_mesh.yaml").write_text(SCENE.replace("primitive: {rectangle: {}}", "file: no.ply"))
        with self.assertRaisesRegex(pathfit.IoError, "no.ply"):
            pathfit.Scene(self.config.with_name("no_mesh.yaml"))
        scene = pathfit.Scene(self.config)
        with self.assertRaisesRegex(KeyError, "back"):
            scene.render("back")
        with self.assertRaisesRegex(IndexError, "there are 2"):
            scene.render(-1)
        with self.assertRaisesRegex(pathfit.SceneError, "bal.vertices"):
            scene.parameters(["bal.vertices"])
        with self.assertRaisesRegex(ValueError, "spp"):
            scene.render(0, spp=0)
        with self.assertRaisesRegex(ValueError, "no photos"):
            scene.photo(0)
        with self.assertRaisesRegex(pathfit.ConfigError, "(?s)a fit needs photos.*at least one stage"):
            scene.fit()
        with self.assertRaisesRegex(ValueError, "format 'fbx' is not one of: glb, obj, ply"):
            scene.write_meshes(self.folder / "meshes", "fbx")
        with self.assertRaisesRegex(ValueError, "threads"):
            pathfit.Scene(self.config, threads=-1)
        with mock.patch.dict(os.environ, {"PATHFIT_THREADS": "many"}):
            with self.assertRaisesRegex(ValueError, "PATHFIT_THREADS: 'many' is not a whole number"):
                pathfit.Scene(self.config)
        parameters = scene.parameters(["lamp.intensity"])
        with self.assertRaisesRegex(ValueError, "2 values for 3"):
            scene.set_values(parameters, np.zeros(2))
        with self.assertRaises(pathfit.SceneError):
            scene.set_values(parameters, np.full(3, np.nan))
        np.testing.assert_array_equal(scene.values(parameters), [6, 6, 6])
        with self.assertRaisesRegex(ValueError, r"\(20, 24, 4\)"):
            scene.gradient(0, parameters, np.zeros((20, 24)))

    def test_other_threads_run_meanwhile(self):
        scene = pathfit.Scene(self.config)
        ticks = []
        done = threading.Event()
        ticker = threading.Thread(target=lambda: [ticks.append(0) for _ in iter(lambda: done.wait(0.005), True)])
        ticker.start()
        scene.render(0, spp=20000)
        done.set()
        ticker.join()
        self.assertGreater(len(ticks), 3)

    def test_fits_to_the_bits_of_the_program(self):
        self.program("synth", self.config, "-o", self.folder / "set", "--spp", 256)
        fit = self.folder / "set" / "fit.yaml"
        text = fit.read_text()
        changes = {"scene.lights.lamp.intensity": [4, 4, 4]}
        run = self.program("fit", fit, "-o", self.folder / "run", "--set", "scene.lights.lamp.intensity=[4, 4, 4]").strip()
        scene = pathfit.Scene(fit, overrides=changes)
        self.assertEqual(scene.photo(0).shape, (20, 24, 3))
        rounds = []
        result = scene.fit(on_round=lambda figures: rounds.append(figures))
        self.assertEqual((result["status"], result["rounds"]), ("finished", len(rounds)), text)
        table = list(csv.DictReader((pathlib.Path(run) / "metrics.csv").read_text().splitlines()))
        self.assertEqual(len(table), len(rounds))
        for line, figures in zip(table, rounds):
            self.assertEqual(float(line["cost_total"]), float(f"{figures['cost_total']:.17g}"))
        fitted = scene.values(scene.parameters(["lamp.intensity"]))
        np.testing.assert_allclose(fitted, [6, 6, 6], rtol=0.05)
        error = result["standard_errors"]["lamp.intensity"]
        self.assertTrue((error > 0).all() and (error < 0.5).all(), error)
        self.assertEqual([p.suffix for p in map(pathlib.Path, scene.write_meshes(self.folder / "meshes"))], [".glb"] * 2)

        again = pathfit.Scene(fit, overrides=changes)
        self.assertEqual(again.fit(on_round=lambda figures: False)["status"], "stopped")
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            pathfit.Scene(fit, overrides=changes).fit(on_round=lambda figures: 1 / 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
