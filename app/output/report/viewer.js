"use strict";
// The 3-D view of the report: meshes, cameras and environment of a model (app/output/viewed_model.h says what is in it),
// drawn by three.js where there is WebGL. Comes before report.js in the page's script.

/** Items of a little-endian buffer in base64. */
function buffer(text, Type) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return new Type(bytes.buffer);
}

/** What the start shares with the result is there once. */
function completed(start, result) {
  if (!start) return null;
  const meshes = start.meshes.map((mesh, i) => {
    const whole = { ...mesh };
    for (const [key, value] of Object.entries(mesh)) {
      if (value === null) whole[key] = result.meshes[i]?.[key];
    }
    return whole;
  });
  return { ...start, meshes };
}

const UNKNOWN = -1; // grey
const UNTOLD = -3; // red: photos do not tell

/** What the vertices' values mean; `values` of a mesh gives one a vertex, null where the mesh has none of it. */
const VIEWED = [
  { key: "color", label: "base colour" },
  { key: "shape", label: "shape only" },
  { key: "normals", label: "normals, as seen: red to the right, green up" },
  ...["roughness", "metallic"].map((key) => ({ key, label: key, share: true, values: (mesh) =>
    (mesh[key] === undefined ? null : new Float32Array(mesh.num_vertices).fill(mesh[key])) })),
  { key: "position_error", label: "standard error of place", unit: "m", log: true,
    values: (mesh) => (mesh.position_error ? buffer(mesh.position_error, Float32Array) : null) },
  { key: "color_error", label: "standard error of colour", unit: "", log: true,
    values: (mesh) => (mesh.color_error ? buffer(mesh.color_error, Float32Array) : null) },
  { key: "photos", label: "photos that show it", unit: "photos",
    values: (mesh) => Float32Array.from(buffer(mesh.photos, Uint8Array)) }];

/** Least and largest finite value of all meshes, what the ends of the ramp stand for; null if there is none. */
function rampEnds(viewed, lists) {
  if (viewed.share) return [0, 1];
  let low = Infinity;
  let high = -Infinity;
  for (const values of lists) {
    for (const value of values ?? []) {
      if (!Number.isFinite(value) || (viewed.log && !(value > 0))) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (viewed.key === "photos") return [0, Math.max(1, high)];
  if (!(low <= high)) return null;
  return low < high ? [low, high] : [low, low * 1.01 + 1e-12];
}

/** Values as shares of the ramp. */
function rampShares(viewed, values, ends) {
  const [low, high] = ends ?? [0, 1];
  const f = viewed.log ? Math.log : (value) => value;
  return values.map((value) => {
    if (Number.isNaN(value)) return UNKNOWN;
    if (value === Infinity) return UNTOLD;
    return Math.min(1, Math.max(0, (f(Math.max(value, viewed.log ? 1e-300 : value)) - f(low)) / (f(high) - f(low))));
  });
}

const VERTEX_SHADER = `
attribute vec3 shownColor;
attribute float shownValue;
attribute float photos;
varying vec3 vPlace, vNormal, vColor;
varying vec2 vUv;
varying float vValue, vPhotos;
void main() {
  vec4 place = modelViewMatrix * vec4(position, 1.0);
  vPlace = place.xyz;
  vNormal = normalMatrix * normal;
  vColor = shownColor;
  vUv = uv;
  vValue = shownValue;
  vPhotos = photos;
  gl_Position = projectionMatrix * place;
}`;

const FRAGMENT_SHADER = `
uniform sampler2D map;
uniform bool hasMap, ramp, shaded, smoothNormals, marked, normals;
varying vec3 vPlace, vNormal, vColor;
varying vec2 vUv;
varying float vValue, vPhotos;
vec3 rampColor(float t) {
  vec3 low = vec3(0.19, 0.14, 0.46), middle = vec3(0.12, 0.60, 0.55), high = vec3(0.98, 0.90, 0.14);
  return t < 0.5 ? mix(low, middle, 2.0 * t) : mix(middle, high, 2.0 * t - 1.0);
}
void main() {
  vec3 color = vColor;
  vec3 texel = hasMap ? texture2D(map, vUv).rgb : vec3(0.0);
  if (ramp) {
    float value = hasMap ? texel.r : vValue;
    color = value < -2.0 ? vec3(0.80, 0.15, 0.13) : value < -0.02 ? vec3(0.55) : rampColor(clamp(value, 0.0, 1.0));
  } else if (hasMap) {
    color = texel;
  }
  vec3 n = smoothNormals ? normalize(vNormal) * (gl_FrontFacing ? 1.0 : -1.0)
                         : normalize(cross(dFdx(vPlace), dFdy(vPlace)));
  float light = shaded ? 0.3 + 0.7 * max(dot(n, normalize(vec3(0.25, 0.45, 1.0))), 0.0) : 1.0;
  if (!gl_FrontFacing) light *= 0.5;
  color = normals ? 0.5 + 0.5 * n : pow(pow(color, vec3(2.2)) * light, vec3(1.0 / 2.2));
  if (marked && vPhotos < 0.5 && fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0) < 0.5) {
    color = mix(color, vec3(0.95, 0.10, 0.75), 0.8);
  }
  gl_FragColor = vec4(color, 1.0);
}`;

/** Rows of world_from_camera as three's matrix, in units of the view. */
function cameraMatrix(camera, place) {
  const [x, y, z] = camera.world_from_camera;
  const at = place([x[3], y[3], z[3]]);
  return new THREE.Matrix4().set(x[0], x[1], x[2], at[0], y[0], y[1], y[2], at[1], z[0], z[1], z[2], at[2], 0, 0, 0, 1);
}

/** Half the width and height, and the middle, of the picture at depth 1 (of parallel rays: of the picture itself). */
function cameraField(camera) {
  const [width, height] = camera.size_px;
  return { halfWidth: width / (2 * camera.fx), halfHeight: height / (2 * camera.fy),
    x: (width / 2 - camera.cx) / camera.fx, y: (camera.cy - height / 2) / camera.fy };
}

function textureFrom(source, repeat, redraw) {
  const image = new Image();
  const texture = new THREE.Texture(image);
  texture.wrapS = texture.wrapT = repeat ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
  texture.generateMipmaps = false;
  texture.minFilter = THREE.LinearFilter;
  image.addEventListener("load", () => {
    texture.needsUpdate = true;
    redraw();
  });
  image.src = source;
  return texture;
}

/** A mesh of the model as three draws it; setShown(viewed, ends) changes what its colours mean. */
function viewedMesh(mesh, place, redraw) {
  const [low, high] = mesh.box;
  const steps = buffer(mesh.positions, Uint16Array);
  const positions = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i += 3) {
    const at = place([0, 1, 2].map((c) => low[c] + (steps[i + c] / 65535) * (high[c] - low[c])));
    positions.set(at, i);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  const Index = mesh.num_vertices <= 65536 ? Uint16Array : Uint32Array;
  geometry.setIndex(new THREE.BufferAttribute(buffer(mesh.triangles, Index), 1));
  if (mesh.normals) geometry.setAttribute("normal", new THREE.BufferAttribute(buffer(mesh.normals, Int8Array), 3, true));
  if (mesh.uvs) geometry.setAttribute("uv", new THREE.BufferAttribute(buffer(mesh.uvs, Float32Array), 2));
  geometry.setAttribute("photos",
    new THREE.BufferAttribute(Float32Array.from(buffer(mesh.photos, Uint8Array)), 1));
  const one = (color) => {
    const colors = new Uint8Array(3 * mesh.num_vertices);
    for (let i = 0; i < colors.length; ++i) colors[i] = color[i % 3];
    return colors;
  };
  const colors = mesh.colors ? buffer(mesh.colors, Uint8Array) : one(mesh.color ?? [128, 128, 128]);
  const textures = {};
  const textureOf = (given, key) => {
    if (given && !textures[key]) textures[key] = textureFrom(given.uri, given.repeat, redraw);
    return textures[key] ?? null;
  };
  const uniforms = { map: { value: null }, hasMap: { value: false }, ramp: { value: false }, shaded: { value: true },
    smoothNormals: { value: Boolean(mesh.normals) }, marked: { value: true },
    normals: { value: false } };
  const material = new THREE.ShaderMaterial({ uniforms, vertexShader: VERTEX_SHADER, fragmentShader: FRAGMENT_SHADER,
    side: THREE.DoubleSide, extensions: { derivatives: true } });
  const object = new THREE.Mesh(geometry, material);
  const setShown = (viewed, ends) => {
    const values = viewed.values?.(mesh);
    const shares = values ? rampShares(viewed, values, ends) : new Float32Array(mesh.num_vertices).fill(UNKNOWN);
    geometry.setAttribute("shownValue", new THREE.BufferAttribute(Float32Array.from(shares), 1));
    geometry.setAttribute("shownColor",
      new THREE.BufferAttribute(viewed.key === "shape" ? one([185, 185, 185]) : colors, 3, true));
    uniforms.map.value = viewed.key === "color" ? textureOf(mesh.texture, "color")
      : viewed.share ? textureOf(mesh[`${viewed.key}_texture`], viewed.key) : null;
    uniforms.normals.value = viewed.key === "normals";
    uniforms.hasMap.value = uniforms.map.value !== null;
    uniforms.ramp.value = Boolean(viewed.values);
  };
  return { object, uniforms, setShown };
}

/** Outline and faces of a camera's field of view; the faces take clicks. */
function frustum(camera, place, size) {
  const field = cameraField(camera);
  const far = camera.parallel ? 0 : size;
  const reach = camera.parallel ? size / Math.max(field.halfWidth, field.halfHeight) / 2 : size;
  const corner = (sx, sy, depth) =>
    [(field.x + sx * field.halfWidth) * reach, (field.y + sy * field.halfHeight) * reach, -depth];
  const signs = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
  const ends = signs.map(([sx, sy]) => corner(sx, sy, far));
  const tops = camera.parallel ? signs.map(([sx, sy]) => corner(sx, sy, -size)) : signs.map(() => [0, 0, 0]);
  const lines = [];
  const faces = [];
  for (let i = 0; i < 4; ++i) {
    const j = (i + 1) % 4;
    lines.push(...ends[i], ...ends[j], ...tops[i], ...ends[i]);
    faces.push(...tops[i], ...ends[i], ...ends[j]);
  }
  // A small roof says where up is.
  const roof = corner(0, 1.35, far);
  lines.push(...ends[2], ...roof, ...roof, ...ends[3]);
  faces.push(...ends[0], ...ends[1], ...ends[2], ...ends[0], ...ends[2], ...ends[3]);
  const list = (numbers) => new THREE.BufferGeometry().setAttribute("position",
    new THREE.BufferAttribute(Float32Array.from(numbers), 3));
  const color = camera.validation ? 0xd9720a : 0x3f7fe8;
  const outline = new THREE.LineSegments(list(lines), new THREE.LineBasicMaterial({ color }));
  const sides = new THREE.Mesh(list(faces), new THREE.MeshBasicMaterial(
    { color, side: THREE.DoubleSide, transparent: true, opacity: 0.12, depthWrite: false }));
  const object = new THREE.Group().add(outline, sides);
  object.matrixAutoUpdate = false;
  object.matrix.copy(cameraMatrix(camera, place));
  return { object, sides, setChosen: (chosen) => {
    outline.material.color.setHex(chosen ? 0xe01030 : color);
    sides.material.color.setHex(chosen ? 0xe01030 : color);
    sides.material.opacity = chosen ? 0.35 : 0.12;
  } };
}

/** Inside of a sphere with an environment on it, in the light's own frame. */
function environmentSphere(source, redraw) {
  const [columns, rows] = [64, 32];
  const positions = [];
  const uvs = [];
  const triangles = [];
  for (let y = 0; y <= rows; ++y) {
    for (let x = 0; x <= columns; ++x) {
      const [u, v] = [x / columns, y / rows];
      const [around, down] = [2 * Math.PI * u, Math.PI * v];
      positions.push(Math.sin(around) * Math.sin(down), Math.cos(down), -Math.cos(around) * Math.sin(down));
      uvs.push(u, 1 - v);
      const at = y * (columns + 1) + x;
      if (x < columns && y < rows) triangles.push(at, at + 1, at + columns + 1, at + 1, at + columns + 2, at + columns + 1);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(positions), 3));
  geometry.setAttribute("uv", new THREE.BufferAttribute(Float32Array.from(uvs), 2));
  geometry.setIndex(triangles);
  const object = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(
    { map: textureFrom(source, false, redraw), side: THREE.DoubleSide, depthWrite: false, depthTest: false }));
  object.renderOrder = -1;
  object.frustumCulled = false;
  return object;
}

/** Middle and size of what is drawn; coordinates of the view are (x - middle) / size. */
function frameOf(model) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const { box } of model.meshes) {
    for (let c = 0; c < 3; ++c) {
      low[c] = Math.min(low[c], box[0][c]);
      high[c] = Math.max(high[c], box[1][c]);
    }
  }
  const size = Math.hypot(...[0, 1, 2].map((c) => high[c] - low[c])) / 2 || 1;
  return (x) => [0, 1, 2].map((c) => (x[c] - (low[c] + high[c]) / 2) / size);
}

/** Mean direction of the cameras' upper edges, where they agree. */
function upOf(cameras) {
  const sum = new THREE.Vector3();
  for (const { world_from_camera: rows } of cameras) sum.add(new THREE.Vector3(rows[0][1], rows[1][1], rows[2][1]));
  return sum.length() > 0.3 * cameras.length ? sum.normalize() : new THREE.Vector3(0, 1, 0);
}

function glContext(canvas) {
  const wanted = { antialias: true, preserveDrawingBuffer: true };
  try {
    return canvas.getContext("webgl2", wanted) ?? canvas.getContext("webgl", wanted);
  } catch {
    return null;
  }
}

/**
 * Draws models ({start, result}, complete) into a box of the page. `environment`: its picture, or null. Returns functions
 * that change what is seen, or null without WebGL. `onChoose(index)` is told of clicks at cameras, -1: none is chosen.
 */
function makeView(box, models, environment, onChoose) {
  const canvas = h("canvas", { "aria-label": "3-D view of the meshes", tabindex: 0 });
  const context = typeof THREE === "undefined" ? null : glContext(canvas);
  if (!context) return null;
  const renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true });
  renderer.autoClear = true;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 200);
  const place = frameOf(models.result);
  const { cameras } = models.result;
  let asked = false;
  const render = () => {
    asked = false;
    sky?.position.copy(camera.position);
    renderer.render(scene, camera);
  };
  const redraw = () => {
    if (!asked) requestAnimationFrame(render);
    asked = true;
  };

  const shapes = {};
  for (const key of ["start", "result"]) {
    if (!models[key]) continue;
    const meshes = models[key].meshes.map((mesh) => viewedMesh(mesh, place, redraw));
    const group = new THREE.Group();
    meshes.forEach((mesh) => group.add(mesh.object));
    scene.add(group);
    shapes[key] = { group, meshes, model: models[key] };
  }

  const matrices = cameras.map((one) => cameraMatrix(one, place));
  const distances = matrices.map((matrix) => new THREE.Vector3().setFromMatrixPosition(matrix).length()).sort((a, b) => a - b);
  const frusta = cameras.map((one) => frustum(one, place, 0.12 * (distances[distances.length >> 1] || 1)));
  const fields = new THREE.Group();
  frusta.forEach((one) => fields.add(one.object));
  scene.add(fields);
  camera.far = 10 * Math.max(5, distances.at(-1) ?? 0);

  const light = models.result.environment;
  const sky = environment && light ? environmentSphere(environment, redraw) : null;
  if (sky) {
    sky.scale.setScalar(0.5 * camera.far);
    scene.add(sky);
  }
  const turnSky = (index) => {
    if (!sky) return;
    const [x, y, z] = light.frame_from_light;
    const turn = new THREE.Matrix4().set(...x, 0, ...y, 0, ...z, 0, 0, 0, 0, 1);
    if (light.frame === "camera" && matrices.length > 0) {
      turn.premultiply(new THREE.Matrix4().extractRotation(matrices[Math.max(index, 0)]));
    }
    sky.quaternion.setFromRotationMatrix(turn);
  };

  const controls = new THREE.OrbitControls(camera, canvas);
  camera.up.copy(upOf(cameras));
  let chosen = -1;
  /** Photo pixels become pixels of the canvas, the same for both directions: returns how many. */
  const lookThrough = () => {
    const one = cameras[chosen];
    const [width, height] = one.size_px;
    const scale = Math.min(box.clientWidth / width, box.clientHeight / height);
    if (one.parallel) return scale;
    const elements = camera.projectionMatrix.elements;
    const [sx, sy] = [(2 * scale) / box.clientWidth, (2 * scale) / box.clientHeight];
    elements[0] = sx * one.fx;
    elements[5] = sy * one.fy;
    elements[8] = -sx * (one.cx - width / 2);
    elements[9] = sy * (one.cy - height / 2);
    camera.projectionMatrixInverse.getInverse(camera.projectionMatrix);
    return scale;
  };
  const resize = () => {
    const [width, height] = [box.clientWidth, box.clientHeight];
    if (!(width > 0 && height > 0)) return;
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    if (chosen >= 0) lookThrough();
    redraw();
  };
  const choose = (index) => {
    chosen = index;
    frusta.forEach((one, i) => {
      one.setChosen(i === index);
      one.object.visible = i !== index; // it would fill the view
    });
    turnSky(index);
    camera.updateProjectionMatrix();
    if (index >= 0) {
      matrices[index].decompose(camera.position, camera.quaternion, new THREE.Vector3());
      const ahead = new THREE.Vector3(0, 0, -1).applyQuaternion(camera.quaternion);
      controls.target.copy(camera.position).addScaledVector(ahead, Math.max(0.1, -camera.position.dot(ahead)));
      camera.updateMatrixWorld();
      lookThrough();
    }
    redraw();
  };
  /** From the direction of the camera that sees the largest box, so near that the meshes, or all cameras, are seen. */
  const reset = (withCameras) => {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((bits) => models.result.meshes.map(({ box }) =>
      new THREE.Vector3(...place([0, 1, 2].map((c) => box[(bits >> c) & 1][c])))));
    const extent = (axis) => {
      const along = corners.map((corner) => corner.dot(axis));
      return Math.max(...along) - Math.min(...along);
    };
    const ahead = new THREE.Vector3(0.5, 0.4, 1);
    let largest = 0;
    for (const matrix of matrices) {
      const [x, y, z] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
      matrix.extractBasis(x, y, z);
      const size = extent(x) * extent(y);
      if (size > largest) ahead.copy(z);
      largest = Math.max(largest, size);
    }
    controls.target.set(0, 0, 0);
    const slant = withCameras ? 0.9 : 0.2;
    camera.position.copy(ahead.normalize()).addScaledVector(camera.up, slant)
      .setLength(withCameras ? 3.3 * Math.max(1, distances.at(-1) ?? 0) : 2.9);
    controls.update();
  };
  controls.addEventListener("start", () => {
    if (chosen >= 0) onChoose(-1);
  });
  controls.addEventListener("change", redraw);

  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  canvas.addEventListener("click", (event) => {
    if (!fields.visible || !pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const bounds = canvas.getBoundingClientRect();
    const at = new THREE.Vector2(2 * ((event.clientX - bounds.left) / bounds.width) - 1,
      1 - 2 * ((event.clientY - bounds.top) / bounds.height));
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, camera);
    const hit = ray.intersectObjects(frusta.map((one) => one.sides))[0];
    if (hit) onChoose(frusta.findIndex((one) => one.sides === hit.object));
  });

  box.append(canvas);
  new ResizeObserver(resize).observe(box);
  resize();
  reset(false);
  turnSky(-1);
  return {
    canvas, choose, reset,
    photoScale: () => (chosen >= 0 ? lookThrough() : 0),
    screenOf: (index) => { // of a camera's frustum, for those who point at it
      const at = new THREE.Vector3(0, 0, -0.06 * (distances[distances.length >> 1] || 1)).applyMatrix4(matrices[index]).project(camera);
      return [0.5 * (at.x + 1) * box.clientWidth, 0.5 * (1 - at.y) * box.clientHeight];
    },
    place: () => [camera.position.toArray(), controls.target.toArray()],
    goTo: ([position, target]) => {
      camera.position.fromArray(position);
      controls.target.fromArray(target);
      controls.update();
    },
    end: () => {
      controls.dispose();
      renderer.dispose();
      renderer.forceContextLoss(); // browsers have few
    },
    onResize: (action) => new ResizeObserver(action).observe(box),
    show: ({ shape, viewed, shaded, marked, fields: withFields, environment: withSky }) => {
      const { meshes, model } = shapes[shape];
      const ends = viewed.values ? rampEnds(viewed, model.meshes.map((mesh) => viewed.values(mesh))) : null;
      for (const [key, one] of Object.entries(shapes)) one.group.visible = key === shape;
      meshes.forEach((mesh) => {
        mesh.setShown(viewed, ends);
        mesh.uniforms.shaded.value = shaded;
        mesh.uniforms.marked.value = marked;
      });
      fields.visible = withFields;
      if (sky) sky.visible = withSky;
      redraw();
      return ends;
    } };
}

// ---- the section

const option = (value, text) => h("option", { value }, text);

/** Vertices of all meshes, and how many of them no photo shows. */
function countVertices(model) {
  let [all, unseen, triangles] = [0, 0, 0];
  for (const mesh of model.meshes) {
    triangles += mesh.num_triangles;
    for (const count of buffer(mesh.photos, Uint8Array)) {
      ++all;
      if (count === 0) ++unseen;
    }
  }
  return { all, unseen, triangles };
}

function modelSection(data) {
  if (!data.model) return null;
  const notes = data.model.note ? note(data.model.note) : null;
  if (!data.model.result) return section("model", "3-D view", h("div", { class: "card" }, notes));
  const models = { result: data.model.result, start: completed(data.model.start, data.model.result) };
  const { cameras } = models.result;
  const counts = countVertices(models.result);
  const shape = h("select", {}, option("result", data.check ? "start" : "fitted"), models.start ? option("start", "start") : null);
  const known = VIEWED.filter((viewed) => !viewed.values || models.result.meshes.some((mesh) => viewed.values(mesh)));
  const viewed = h("select", {}, known.map(({ key, label }) => option(key, label)));
  const photo = h("select", {}, option("-1", "free view"), option("-2", "all cameras from outside"), cameras.map((one, i) =>
    option(i, one.name + (one.validation ? " (held out)" : ""))));
  const check = (text, on) => {
    const box = h("input", { type: "checkbox", ...(on ? { checked: "" } : {}) });
    return { box, node: h("label", {}, box, " ", text) };
  };
  const shaded = check("shading", true);
  const marked = check("mark what no photo shows", true);
  const fields = check("cameras", true);
  const sky = check("environment", false);
  const withSky = Boolean(data.environment.final && models.result.environment);
  const over = h("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0, "aria-label": "photo over the shape" });
  const overLabel = h("label", { class: "over" }, "shape ", over, " photo");
  const legend = h("p", { class: "scale" });
  const box = h("div", { class: "viewer" });
  const photoBox = h("p", { class: "note" });
  const errors = data.check || known.some((one) => one.log && rampEnds(one, models.result.meshes.map((mesh) => one.values(mesh)))) ? ""
    : " Standard errors of single vertices are not known.";
  const node = section("model", "3-D view", h("div", { class: "card" },
    h("div", { class: "tools" }, h("label", {}, "shape: ", shape), h("label", {}, "colours: ", viewed),
      h("label", {}, "look through: ", photo), shaded.node, marked.node, fields.node, withSky ? sky.node : null),
    box, legend, photoBox, notes,
    note(`${counts.triangles} triangles. `, counts.unseen === 0 ? "Every vertex is shown by a fitted photo."
      : `No fitted photo shows ${counts.unseen} of ${counts.all} vertices (striped).`, errors,
    " Drag to turn, wheel to move nearer, right button to shift; click at a camera (blue: fitted, orange: held out) to look " +
    "through it, without its lens distortion. The shading is the viewer's, not the fit's light." +
    (withSky && models.result.environment.frame === "camera" ? " The environment goes with the camera: it is that of the chosen photo." : ""))));

  // Of a section that is drawn anew as its run goes on, what was chosen stays.
  const chosenBy = [shape, viewed, photo, over];
  const boxes = [shaded.box, marked.box, fields.box, sky.box];
  let view = null;
  const kept = () => {
    const place = view?.place();
    view?.end();
    return { values: chosenBy.map((one) => one.value), checks: boxes.map((one) => one.checked), place };
  };
  const start = (before) => {
    let chosen = -1;
    view = makeView(box, models, data.environment.final, (index) => pick(index));
    if (!view) {
      box.append(h("p", { class: "empty" }, "This browser draws no 3-D pictures here (WebGL is off or missing). " +
        (data.check ? "" : "The meshes are in the run's folder result. ") + "Everything else on this page works without it."));
      return;
    }
    const overlay = h("img", { class: "overlay", alt: "" });
    box.append(overlay);
    const fit = () => {
      const scale = view.photoScale();
      if (!(scale > 0)) return;
      const [width, height] = cameras[chosen].size_px;
      overlay.style.width = scale * width + "px";
      overlay.style.height = scale * height + "px";
    };
    const fade = () => { overlay.style.opacity = over.value; };
    const pick = (index) => {
      chosen = index;
      view.choose(index);
      photo.value = String(index);
      const pictures = data.views.find((one) => one.index === index)?.pictures ?? {};
      overlay.style.display = index >= 0 && pictures.photo ? "" : "none";
      photoBox.replaceChildren();
      if (index < 0) return;
      if (pictures.photo) {
        overlay.src = pictures.photo;
        fit();
        photoBox.append(overLabel, " ", h("a", { href: "#view" + index }, data.check ? "the start over it" : "its photo, rendering and difference"));
      } else {
        photoBox.append(`The pictures of ${cameras[index].name} are not in this page, but in the run's folder images.`);
      }
    };
    const update = () => {
      const one = known.find(({ key }) => key === viewed.value);
      const ends = view.show({ shape: shape.value, viewed: one, shaded: shaded.box.checked, marked: marked.box.checked,
        fields: fields.box.checked, environment: sky.box.checked });
      legend.replaceChildren();
      if (!one.values) return;
      const unit = one.unit ? " " + one.unit : "";
      const scale = ends ? [number(ends[0]) + unit, h("span", { class: "ramp viewed" }), number(ends[1]) + unit] : ["not known"];
      legend.append(one.label + ": ", ...scale);
      if (one.log) legend.append(ends ? " (log scale; red: photos do not tell, grey: not known)" : " (grey); red: photos do not tell");
    };
    for (const one of [shape, viewed, shaded.box, marked.box, fields.box, sky.box]) one.addEventListener("change", update);
    photo.addEventListener("change", () => {
      const index = Number(photo.value);
      pick(Math.max(index, -1));
      photo.value = String(index);
      if (index < 0) view.reset(index === -2);
    });
    over.addEventListener("input", fade);
    view.onResize(fit);
    before?.values.forEach((value, i) => {
      const one = chosenBy[i];
      if (one.tagName === "INPUT" || [...one.options].some((given) => given.value === value)) one.value = value;
    });
    before?.checks.forEach((checked, i) => { boxes[i].checked = checked; });
    const wanted = photo.value;
    pick(Math.max(Number(wanted), -1));
    photo.value = wanted;
    if (before?.place && Number(wanted) < 0) view.goTo(before.place);
    fade();
    update();
    view.canvas.addEventListener("webglcontextlost", () => {
      if (!box.isConnected) return;
      box.replaceChildren(h("p", { class: "empty" }, "The browser gave the 3-D view up; load the page again to have it back."));
    });
    box.view = view; // for scripts
  };
  return { ...node, start, kept };
}

