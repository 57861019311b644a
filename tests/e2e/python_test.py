"""The Python module: pictures, derivatives and fits are those of the program.

Usage: python_test.py PATHFIT SOURCE_DIR MODULE_FOLDER. Unittest output; exits 1 if anything fails.
"""
import ast
import csv
import inspect
import os
import pathlib
import runpy
import subprocess
import sys
import tempfile
import threading
import types
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
        budgets = {"render.sppe": 8, "render.spp_direct": 8, "render.spp_indirect": 8, "render.spp_pixel": 4}
        scene = pathfit.Scene(self.config, budgets)
        parameters = scene.parameters(["ball.vertices", "lamp.intensity", "camera.position"])
        self.assertEqual(len(parameters), 162 * 3 + 3 + 6)
        self.assertEqual(parameters.groups[1], {"name": "lamp.intensity", "first": 486, "shape": (1, 3)})
        self.assertEqual(parameters.name_of(4), "ball.vertices[1].y")
        jacobian = scene.jacobian("front", parameters)
        self.assertEqual(jacobian.shape, (20 * 24 * 4, len(parameters)))
        self.assertEqual((jacobian.dtype, jacobian.indices.dtype, jacobian.indptr.dtype), (np.float32, np.int32, np.int32))
        self.assertTrue(jacobian.has_canonical_format)
        self.assertEqual(np.count_nonzero(jacobian.data), jacobian.nnz)
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

    def test_changed_values_give_the_bits_of_a_scene_that_began_with_them(self):
        scene = pathfit.Scene(self.config)
        vertices = scene.parameters(["ball.vertices"])
        moved = scene.values(vertices) + np.tile([0.1, 0, 0.05], 162)
        scene.set_values(vertices, moved)
        scene.set_values(scene.parameters(["paint.base_color"]), [0.2, 0.4, 0.9])
        fresh = pathfit.Scene(self.config, {"scene.materials.paint.base_color.constant": [0.2, 0.4, 0.9]})
        fresh.set_values(vertices, moved)
        self.assertTrue(np.array_equal(scene.render(0), fresh.render(0)))
        before = scene.render(0)
        moved[40] = np.inf
        with self.assertRaises(pathfit.SceneError):
            scene.set_values(vertices, moved)
        self.assertTrue(np.array_equal(scene.render(0), before))

    def test_arrays_own_their_numbers(self):
        scene = pathfit.Scene(self.config)
        parameters = scene.parameters(["ball.vertices"])
        picture, jacobian, values = scene.render(0), scene.jacobian(0, parameters), scene.values(parameters)
        copies = [picture.copy(), jacobian.data.copy(), values.copy()]
        scene.set_values(parameters, 1.1 * values)
        del scene
        for array, copy in zip((picture, jacobian.data, values), copies):
            self.assertTrue(array.flags.writeable and array.flags.c_contiguous)
            self.assertTrue(np.array_equal(array, copy))

    def test_text_and_dicts_are_scenes_too(self):
        expected = pathfit.Scene(self.config).render(0)
        self.assertTrue(np.array_equal(pathfit.Scene.from_string(SCENE).render(0), expected))
        look = {"target_m": np.zeros(3), "origin_m": (0, 0, np.float32(3))}
        scene = {
            "schema": 1,
            "seed": np.int64(5),
            "scene": {
                "geometry": {
                    "ball": {"primitive": {"sphere": {"subdivisions": 2}}, "material": "paint", "transform": {"scale": 0.5}},
                    "floor": {
                        "mesh": {"vertices": np.array([[-2, -2, -0.6], [2, -2, -0.6], [2, 2, -0.6], [-2, 2, -0.6]]),
                                 "triangles": np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint16)},
                        "material": "grey"}},
                "materials": {"paint": {"model": "diffuse", "base_color": {"constant": [0.7, 0.4, 0.2]}},
                              "grey": {"model": "diffuse", "base_color": {"constant": [0.5] * 3}}},
                "lights": {"lamp": {"type": "point", "position_m": [-1.5, 0.5, 2], "intensity": [6, 6, 6]}},
                "sensors": {"front": {"size_px": [24, 20], "fov_deg": 50, "pose": {"look_at": look}}}},
            "render": {"spp": 16}}
        built = pathfit.Scene.from_dict(scene)
        self.assertEqual(built.views, ["front"])
        np.testing.assert_allclose(built.render(0), expected, atol=1e-6)
        np.testing.assert_array_equal(built.values(built.parameters(["floor.vertices"]))[:3], [-2, -2, -0.6])

        with self.assertRaisesRegex(pathfit.ConfigError, r"<string>:2:1: error: unknown key .spp."):
            pathfit.Scene.from_string("schema: 1\nspp: 3\n")
        with self.assertRaisesRegex(pathfit.ConfigError, r"(?s)<dict>: error: name\[0\]: a builtin_function_or_method is no value.*render\.spp: -1 is out"):
            pathfit.Scene.from_dict({**scene, "render": {"spp": -1}, "name": [print]})
        with self.assertRaisesRegex(pathfit.ConfigError, "(?s)the key 7 is no text"):
            pathfit.Scene.from_dict({**scene, 7: 1})
        scene["scene"]["geometry"]["floor"]["mesh"]["triangles"][1] = [0, 2, 9]
        with self.assertRaisesRegex(pathfit.ConfigError, r"<dict>: error: scene\.geometry\.floor\.mesh\.triangles: there is no vertex 9"):
            pathfit.Scene.from_dict(scene)
        endless = {}
        endless["endless"] = endless
        with self.assertRaisesRegex(pathfit.ConfigError, "deeper than 64"):
            pathfit.Scene.from_dict(endless)
        with self.assertRaisesRegex(TypeError, "a object is no value"):
            pathfit.Scene(self.config, {"render.spp": object()})

    def test_help_says_what_the_stub_says(self):
        def check(node, thing):
            for child in node.body:
                if isinstance(child, (ast.ClassDef, ast.FunctionDef)):
                    says = inspect.getdoc(getattr(thing, child.name))
                    self.assertTrue(says.endswith(ast.get_docstring(child)), child.name)
                    check(child, getattr(thing, child.name))
        stub = ast.parse((SOURCE / "app" / "python" / "pathfit.pyi").read_text())
        check(stub, pathfit)
        self.assertEqual(pathfit.__doc__, ast.get_docstring(stub))
        for thing in (pathfit, pathfit.Scene, pathfit.Parameters):
            node = stub if thing is pathfit else next(c for c in stub.body if getattr(c, "name", "") == thing.__name__)
            written = {c.name for c in node.body if isinstance(c, (ast.ClassDef, ast.FunctionDef))}
            self.assertEqual({n for n in vars(thing) if not n.startswith("_")} - written, set())

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
        for view in (-1, 2, 2**70, np.int64(2)):
            with self.assertRaisesRegex(IndexError, "there are 2"):
                scene.render(view)
        np.testing.assert_array_equal(scene.render(np.uint8(1)), scene.render(1))
        with self.assertRaisesRegex(TypeError, "a name or a whole number"):
            scene.render(1.0)
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
        (self.folder / "a_file").write_text("")
        with self.assertRaisesRegex(pathfit.IoError, "a_file/meshes: cannot be created"):
            scene.write_meshes(self.folder / "a_file" / "meshes")
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
        other = pathfit.Scene.from_string(SCENE.replace("subdivisions: 2", "subdivisions: 1"))
        foreign = other.parameters(["ball.vertices"])
        for use in (scene.values, lambda p: scene.set_values(p, other.values(p)), lambda p: scene.jacobian(0, p),
                    lambda p: scene.gradient(0, p, np.zeros((20, 24, 4))), scene.not_in_the_derivative):
            with self.assertRaisesRegex(pathfit.SceneError, "of another scene: 'ball.vertices'"):
                use(foreign)
        with self.assertRaisesRegex(ValueError, r"\(20, 24, 4\)"):
            scene.gradient(0, parameters, np.zeros((20, 24)))

    def test_tutorial_s_autograd_function_without_torch(self):
        class Tensor:
            def __init__(self, array):
                self.array = array

            def detach(self):
                return self

            def numpy(self):
                return self.array

        class Context:
            def save_for_backward(self, *tensors):
                self.saved_tensors = tensors

        stand_in = types.ModuleType("torch")
        stand_in.autograd = types.SimpleNamespace(Function=object)
        stand_in.from_numpy = Tensor
        with mock.patch.dict(sys.modules, {"torch": stand_in}):
            tutorial = runpy.run_path(str(SOURCE / "configs" / "tutorials" / "python" / "autograd.py"))
        scene = pathfit.Scene(self.config)
        rendering = tutorial["Rendering"](scene, ["lamp.intensity"])
        context, values = Context(), Tensor(np.array([5.0, 6.0, 7.0]))
        picture = tutorial["Pictures"].forward(context, values, rendering, "side").array
        weights = Tensor(np.broadcast_to(1.0, picture.shape))
        gradient, *others = tutorial["Pictures"].backward(context, weights)
        self.assertEqual(others, [None, None])
        self.assertEqual((picture.shape, gradient.array.shape), ((20, 24, 4), (3,)))
        self.assertTrue(np.array_equal(picture, scene.render("side", seed=1)))
        expected = scene.gradient("side", rendering.parameters, np.ones(picture.shape), seed=2)
        self.assertTrue(np.array_equal(gradient.array, expected))
        np.testing.assert_array_equal(rendering.values(), values.array)

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
        for limit in (-1.0, np.nan):
            with self.assertRaisesRegex(ValueError, "time_limit_s"):
                scene.fit(time_limit_s=limit)
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


        for stop in ("round", "stage", "view", "warning", "message"):
            calls = []
            again = pathfit.Scene(fit, overrides=changes)
            answer = again.fit(**{f"on_{stop}": lambda *arguments: calls.append(arguments) or (False if stop == "round" else np.False_)})
            self.assertEqual(answer["status"], "stopped" if calls else "finished", stop)
            self.assertEqual(bool(calls), stop not in ("warning", "message") or bool(answer[f"{stop}s"]))
            if stop == "view":
                stage, view, picture, photo = calls[0]
                self.assertEqual((stage, view, picture.shape[2], photo.shape[2]), ("start", scene.views[0], 4, 3))
                self.assertEqual(picture.shape[:2], photo.shape[:2])
        again = pathfit.Scene(fit, overrides=changes)
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            again.fit(on_round=lambda figures: 1 / 0)
        np.testing.assert_array_equal(again.values(again.parameters(["lamp.intensity"])), [4, 4, 4])

        checkpoints = self.folder / "checkpoints" / "here"
        stopped = pathfit.Scene(fit, overrides=changes)
        self.assertEqual(stopped.fit(on_round=lambda _: False, checkpoints=checkpoints)["rounds"], 1)
        with self.assertRaisesRegex(pathfit.IoError, "here: is not empty; resume=True continues"):
            stopped.fit(checkpoints=checkpoints)
        with self.assertRaisesRegex(pathfit.IoError, "(?s)no checkpoint can be read.*state_"):
            stopped.fit(checkpoints=checkpoints, resume=True)
        with self.assertRaisesRegex(ValueError, "resume needs the folder"):
            stopped.fit(resume=True)
        resumed = pathfit.Scene(fit, overrides=changes)
        self.assertEqual(resumed.fit(checkpoints=checkpoints, resume=True)["rounds"], len(rounds))
        self.assertTrue(np.array_equal(resumed.values(resumed.parameters(["lamp.intensity"])), fitted))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
