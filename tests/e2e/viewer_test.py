"""Our GLB in the loader of three.js, in a headless Chromium: no complaint, and the same silhouette as our own masks.

Usage: viewer_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import functools
import http.server
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

PATHFIT = pathlib.Path(sys.argv[1])
SOURCE = pathlib.Path(sys.argv[2]).resolve()
sys.path.insert(0, str(SOURCE / "tests" / "support"))
import browser  # noqa: E402

THREE = pathlib.Path("/usr/share/javascript/three")
WIDTH, HEIGHT, FOV_Y = 640, 480, 40

SCENE = f"""schema: 1
name: viewed
seed: 3
scene:
  geometry:
    ball: {{primitive: {{sphere: {{subdivisions: 3}}}}, material: plastic, normals: smooth, transform: {{scale: 0.5, translate_m: [0.9, 0.2, 0]}}}}
    painted: {{primitive: {{sphere: {{subdivisions: 3}}}}, material: paint, transform: {{scale: 0.4, translate_m: [-0.9, 0, 0.3]}}}}
    woven: {{primitive: {{rectangle: {{}}}}, material: cloth, normals: smooth, transform: {{scale: 0.45, translate_m: [0, 0.6, -0.5]}}}}
  textures:
    weave: {{file: {SOURCE / "tests" / "scenes" / "weave.png"}}}
    bumps: {{size_px: [8, 8], init: {{constant: [0.6, 0.45, 1.0]}}}}
  materials:
    plastic: {{model: metallic_roughness, base_color: {{constant: [0.1, 0.3, 0.7]}}, roughness: {{constant: 0.4}}, metallic: {{constant: 0}}}}
    paint: {{model: metallic_roughness, base_color: {{vertex: [0.8, 0.4, 0.2]}}, roughness: {{constant: 0.6}}, metallic: {{constant: 0}}}}
    cloth: {{model: metallic_roughness, base_color: {{texture: weave}}, roughness: {{constant: 0.8}}, metallic: {{constant: 0}}, normal: {{texture: bumps, scale: 0.5}}}}
  lights:
    room: {{type: constant, radiance: [0.8, 0.8, 0.8], visible: false}}
  sensors:
    a: {{size_px: [{WIDTH}, {HEIGHT}], fov_deg: {FOV_Y}, pose: {{look_at: {{origin_m: [0.3, 0.4, 3.5], target_m: [0, 0.2, 0]}}}}}}
    b: {{size_px: [{WIDTH}, {HEIGHT}], fov_deg: {FOV_Y}, pose: {{look_at: {{origin_m: [-1.5, 1.2, 3.0], target_m: [0, 0.2, 0]}}}}}}
unknowns: {{room.intensity: {{}}}}
"""

PAGE = """<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,"><body style="margin:0">
<script src="three.min.js"></script><script src="GLTFLoader.js"></script><script>
const renderer = new THREE.WebGLRenderer({ antialias: false, alpha: true, preserveDrawingBuffer: true });
renderer.setSize(WIDTH, HEIGHT);
renderer.setClearColor(0x000000, 0);
renderer.gammaOutput = true;
document.body.appendChild(renderer.domElement);
const scene = new THREE.Scene();
scene.add(new THREE.HemisphereLight(0xffffff, 0xffffff, 3));
const camera = new THREE.PerspectiveCamera(FOV_Y, WIDTH / HEIGHT, 0.01, 100);
camera.matrixAutoUpdate = false;
let state = "loading", materials = [];
new THREE.GLTFLoader().load("scene.glb", (gltf) => {
  gltf.scene.traverse((node) => { if (node.isMesh) materials.push([node.name, node.material.name, !!node.material.normalMap]); });
  scene.add(gltf.scene);
  state = "loaded";
}, undefined, (error) => { state = String(error); });
function draw(rows) {
  camera.matrix.set(...rows);
  camera.updateMatrixWorld(true);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), bytes = new Uint8Array(4 * WIDTH * HEIGHT);
  gl.readPixels(0, 0, WIDTH, HEIGHT, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let mask = "", colors = new Set();
  for (let y = HEIGHT - 1; y >= 0; --y) {
    for (let x = 0; x < WIDTH; ++x) {
      const i = 4 * (y * WIDTH + x);
      mask += bytes[i + 3] > 127 ? "1" : "0";
      if (bytes[i + 3] > 127) colors.add((bytes[i] << 16) + (bytes[i + 1] << 8) + bytes[i + 2]);
    }
  }
  return { mask, colors: colors.size };
}
</script>"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Viewer(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_viewer_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def test_three_js_shows_the_meshes_where_we_do(self):
        config = self.folder / "viewed.yaml"
        config.write_text(SCENE)
        made = subprocess.run([PATHFIT, "synth", config, "-o", self.folder / "set", "--format", "png", "--spp", "4"],
                              capture_output=True, text=True, timeout=600)
        self.assertEqual(made.returncode, 0, made.stderr)
        web = self.folder / "web"
        web.mkdir()
        shutil.copy(next(p for p in (THREE / "three.min.js", THREE / "build" / "three.min.js") if p.exists()), web / "three.min.js")
        shutil.copy(THREE / "examples" / "js" / "loaders" / "GLTFLoader.js", web)
        shutil.copy(self.folder / "set" / "truth" / "scene.glb", web)
        page = PAGE.replace("WIDTH", str(WIDTH)).replace("HEIGHT", str(HEIGHT)).replace("FOV_Y", str(FOV_Y))
        (web / "index.html").write_text(page)
        cameras = json.loads((self.folder / "set" / "transforms.json").read_text())
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=web))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        with browser.Browser(size=(WIDTH, HEIGHT)) as tab:
            tab.open(f"http://127.0.0.1:{server.server_address[1]}/index.html")
            tab.wait('state !== "loading"')
            self.assertEqual(tab.eval("state"), "loaded")
            self.assertEqual(sorted(tab.eval("materials")),
                             [["ball", "plastic", False], ["painted", "paint", False], ["woven", "cloth", True]])
            for frame in cameras["frames"]:
                drawn = tab.eval(f"draw({json.dumps(sum(frame['transform_matrix'], []))})")
                self.assertGreater(drawn["colors"], 50)
                mask = self.folder / "set" / "masks" / (pathlib.Path(frame["file_path"]).name + ".png")
                rows = browser.pixels(mask.read_bytes())
                ours = [pixel[0] > 127 for row in rows for pixel in row]
                theirs = [bit == "1" for bit in drawn["mask"]]
                self.assertEqual(len(ours), len(theirs))
                both = sum(a and b for a, b in zip(ours, theirs))
                either = sum(a or b for a, b in zip(ours, theirs))
                print(f"{frame['file_path']}: IoU {both / either:.4f}, {drawn['colors']} colours", file=sys.stderr)
                self.assertGreater(both, 0.1 * WIDTH * HEIGHT)
                self.assertGreater(both / either, 0.99)
            self.assertEqual(tab.complaints, [])


if __name__ == "__main__":
    if browser.CHROMIUM is None:
        print("no Chromium")
        sys.exit(1)
    unittest.main(argv=sys.argv[:1], verbosity=2)
