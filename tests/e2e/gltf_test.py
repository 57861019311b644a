"""GLB files of every kind that pathfit writes, by the validator of the Khronos Group.

Usage: gltf_test.py PATHFIT SOURCE_DIR [GLB...]. Skipped (exit 77) where node finds no module gltf-validator:
scripts/test.sh installs it (package.json here) and names its folder in NODE_PATH. Unittest output; exits 1 if anything
fails. With files, validates these alone.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATHFIT = pathlib.Path(sys.argv[1])
SOURCE = pathlib.Path(sys.argv[2]).resolve()

VALIDATE = """
const validator = require("gltf-validator"), fs = require("fs");
(async () => {
  const reports = {};
  for (const path of process.argv.slice(1)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)), { maxIssues: 20 });
    reports[path] = report.issues;
  }
  console.log(JSON.stringify({ version: validator.version(), reports }));
})();
"""

SCENE = """schema: 1
name: kinds
seed: 3
scene:
  geometry:
    plain: {primitive: {sphere: {subdivisions: 1}}, material: metal}
    smooth: {primitive: {sphere: {subdivisions: 3}}, material: plastic, normals: smooth, transform: {scale: 0.4, translate_m: [1, 0, 0]}}
    colored: {primitive: {sphere: {subdivisions: 4}}, material: painted, transform: {scale: 0.5, translate_m: [-1, 0, 0]}}
    woven: {primitive: {rectangle: {}}, material: cloth, transform: {translate_m: [0, 1, 0]}}
    lamp: {primitive: {disk: {}}, material: metal, transform: {scale: 0.3, translate_m: [0, 2, 2]}}
  textures:
    weave: {file: WEAVE}
    gloss: {size_px: [4, 8], init: {constant: [0.4, 0.4, 0.4]}}
    metals: {size_px: [2, 2], init: {constant: [0.7, 0.7, 0.7]}}
  materials:
    metal: {model: metallic_roughness, base_color: {constant: [0.9, 0.7, 0.3]}, roughness: {constant: 0.3}, metallic: {constant: 1}}
    plastic: {model: metallic_roughness, base_color: {constant: [0.1, 0.3, 0.7]}, roughness: {constant: 0.4}, metallic: {constant: 0}, specular: 0.5}
    painted: {model: diffuse, base_color: {vertex: [0.6, 0.4, 0.2]}}
    cloth: {model: metallic_roughness, base_color: {texture: weave}, roughness: {texture: gloss}, metallic: {texture: metals}}
  lights:
    lamp_light: {type: area, mesh: lamp, radiance: [20, 18, 15]}
    room: {type: constant, radiance: [0.5, 0.5, 0.5], visible: false}
  sensors:
    a: {size_px: [24, 20], fov_deg: 60, pose: {look_at: {origin_m: [0, 0, 4], target_m: [0, 0, 0]}}}
    b: {size_px: [24, 20], fov_deg: 60, pose: {look_at: {origin_m: [2, 1, 3], target_m: [0, 0, 0]}}}
unknowns: {colored.colors: {}, room.intensity: {}}
"""


def validate(paths):
    """Issues by path; None without the validator."""
    result = subprocess.run(["node", "-e", VALIDATE, *map(str, paths)], capture_output=True, text=True, timeout=300)
    if "Cannot find module" in result.stderr:
        return None
    if result.returncode != 0:
        raise RuntimeError(result.stderr)
    answer = json.loads(result.stdout)
    print(f"gltf-validator {answer['version']}: {len(answer['reports'])} files", file=sys.stderr)
    return answer["reports"]


class Gltf(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_gltf_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def done(self, *arguments):
        result = subprocess.run([PATHFIT, *map(str, arguments)], capture_output=True, text=True, timeout=600)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
        return result

    def test_all_kinds_are_without_errors_and_warnings(self):
        config = self.folder / "kinds.yaml"
        config.write_text(SCENE.replace("WEAVE", str(SOURCE / "tests" / "scenes" / "weave.png")))
        self.done("synth", config, "-o", self.folder / "set", "--spp", "4")
        cameras = self.folder / "set" / "transforms.json"
        text = json.loads(cameras.read_text())
        text["metres_per_unit"] = 0.01
        cameras.write_text(json.dumps(text))
        self.done("fit", self.folder / "set" / "fit.yaml", "-o", self.folder / "run", "--progress", "none",
                  "--set", "stages.all.max_rounds=1", "--set", "output.report=false")
        self.done("export", self.folder / "run", "--to", "glb", "--triangles", "300", "-o", self.folder / "coarse")
        files = [p for part in ("set/truth", "run/result", "coarse") for p in sorted((self.folder / part).glob("*.glb"))]
        self.assertEqual(len(files), 18)  # five meshes and all of them, three times
        coarse = (self.folder / "coarse" / "colored.glb").read_bytes()
        self.assertIn(b"normalTexture", coarse)
        for path, issues in validate(files).items():
            self.assertEqual((issues["numErrors"], issues["numWarnings"]), (0, 0), f"{path}: {issues['messages']}")


if __name__ == "__main__":
    if len(sys.argv) > 3:
        found = validate(sys.argv[3:])
        print(json.dumps(found, indent=1))
        sys.exit(found is None or any(i["numErrors"] + i["numWarnings"] for i in found.values()))
    if validate([]) is None:
        print("SKIPPED: node has no module gltf-validator (NODE_PATH=" + os.environ.get("NODE_PATH", "") + ")")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
