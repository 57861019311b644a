"use strict";
// Runs the script of the report's page on data that is good, missing or hostile, with as much of a document as it uses.
//
// Usage: node report_page_test.js viewer.js report.js [report.html ...]: the pages given are drawn too.
const assert = require("node:assert");
const fs = require("node:fs");
const vm = require("node:vm");

class Element {
  constructor(namespace, tag) {
    Object.assign(this, { namespace, tag, attributes: {}, children: [], listeners: {}, parent: null, words: "",
      style: {} });
    const names = () => (this.attributes.class ?? "").split(" ").filter((name) => name);
    this.classList = {
      contains: (name) => names().includes(name),
      toggle: (name, on = !names().includes(name)) => {
        this.attributes.class = [...names().filter((one) => one !== name), ...(on ? [name] : [])].join(" ");
        return on;
      },
    };
  }
  setAttribute(name, value) { this.attributes[name] = String(value); }
  get tagName() { return this.namespace ? this.tag : this.tag.toUpperCase(); }
  set src(value) { this.attributes.src = value; }
  get src() { return this.attributes.src; }
  set value(value) { this.attributes.value = String(value); }
  get value() { return this.attributes.value; }
  set alt(value) { this.attributes.alt = value; }
  get alt() { return this.attributes.alt; }
  append(...nodes) {
    for (const node of nodes) {
      assert.ok(typeof node === "string" || node instanceof Element, `${this.tag} got ${node}`);
      if (node instanceof Element) node.parent = this;
      this.children.push(node);
    }
  }
  replaceChildren(...nodes) {
    this.children = [];
    this.append(...nodes);
  }
  before(node) {
    node.parent = this.parent;
    this.parent.children.splice(this.parent.children.indexOf(this), 0, node);
  }
  remove() { this.parent.children.splice(this.parent.children.indexOf(this), 1); }
  get previousElementSibling() { return this.parent.children[this.parent.children.indexOf(this) - 1] ?? null; }
  get firstChild() { return this.children[0]; }
  set textContent(text) { this.children = [text]; }
  get textContent() { return this.children.map((c) => (typeof c === "string" ? c : c.textContent)).join(""); }
  addEventListener(name, action) { this.listeners[name] = action; }
  getBoundingClientRect() { return { left: 0, width: 520 }; }
  all(wanted = () => true) {
    return this.children.filter((c) => c instanceof Element).flatMap((c) => [...(wanted(c) ? [c] : []), ...c.all(wanted)]);
  }
  tagged(tag) { return this.all((node) => node.tag === tag); }
  classed(name) { return this.all((node) => node.classList.contains(name)); }
}

/** Draws and checks what must hold for any data; returns the page's <main> and the script's functions. */
function draw(script, data) {
  const main = new Element(null, "main");
  const document = {
    createElement: (tag) => new Element(null, tag),
    createElementNS: (namespace, tag) => new Element(namespace, tag),
    getElementById: () => ({ textContent: JSON.stringify(data) }),
    querySelector: () => main,
  };
  const context = vm.createContext({ document, console, atob });
  vm.runInContext(script, context);
  for (const node of main.all()) {
    for (const [name, value] of Object.entries(node.attributes)) {
      assert.ok(!name.startsWith("on") && name !== "style", `${node.tag} has ${name}`);
      if (name === "src") assert.match(value, /^data:image\/(jpeg|png);base64,/);
      if (name === "href") assert.match(value, node.tag === "image" ? /^data:image\/jpeg;base64,/ : /^#/);
      if (!["class", "title", "alt", "aria-label", "src"].includes(name)) {
        assert.doesNotMatch(value, /NaN|Infinity|undefined|null/, `${node.tag} ${name}`);
      }
    }
    assert.ok(!["script", "style", "iframe", "object", "link"].includes(node.tag), node.tag);
  }
  for (const node of [...main.tagged("td"), ...main.tagged("text"), ...main.tagged("b")]) {
    assert.doesNotMatch(node.textContent, /NaN|Infinity|undefined|\[object/);
  }
  const links = main.tagged("a").map((a) => a.attributes.href.slice(1));
  assert.deepStrictEqual(links, main.tagged("section").map((one) => one.attributes.id).filter((id) => id));
  return { main, links, context, title: document.title };
}

const figure = (key, more = {}) => ({ key, unit: "", label: key, doc: "", chart: "", by_stage: "", ...more });

const base64 = (items) => Buffer.from(items.buffer).toString("base64");

/** A triangle whose last corner no photo shows, and a camera. */
function someModel(word) {
  const mesh = { name: word, num_vertices: 3, num_triangles: 1, box: [[0, 0, 0], [1, 2, 0]],
    positions: base64(Uint16Array.from([0, 0, 0, 65535, 0, 0, 0, 65535, 0])), triangles: base64(Uint16Array.from([0, 1, 2])),
    colors: base64(Uint8Array.from([255, 0, 0, 0, 255, 0, 0, 0, 255])), photos: base64(Uint8Array.from([2, 1, 0])),
    roughness: 0.5, metallic: 0.25, position_error: base64(Float32Array.from([0.01, NaN, Infinity])) };
  const camera = { name: word, validation: true, size_px: [4, 3], fx: 4, fy: 4, cx: 2, cy: 1.5, parallel: false,
    world_from_camera: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]] };
  const result = { version: 1, meshes: [mesh], cameras: [camera],
    environment: { frame: "camera", frame_from_light: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] } };
  return { start: { ...result, meshes: [{ ...mesh, triangles: null }] }, result, note: "" };
}

function someData(word = "axe") {
  const view = (name, validation) => ({ name, validation, psnr_linear_db: 20, psnr_srgb_db: 21, iou: 0.9, gain: 1.1 });
  const views = [view(word + "1", true), view(word + "2", false)];
  const stage = (name, quality) => ({ after_step: 0, stage: name, rounds: name === "start" ? 0 : 3, cost_before: 2,
    psnr_srgb_val_db: quality, psnr_srgb_fit_db: quality, iou_fit: 0.9, iou_val: 0.9, stop_reason: word, views });
  const rounds = [1, 2, 3].map((step) => ({ step, stage: word, wall_s: 2 * step, cost_total: 1 / step, spp: 4,
    render_s: 1, accepted: step !== 2, linear_solver: word }));
  return {
    run_path: word, status: "finished", sentence: word, warnings: [word], num_inputs: 400, seed: "18446744073709551615",
    run: { name: word, started_utc: word, ended_utc: word, wall_s: 6, program_version: word, build: word, threads: 2,
      libraries: { [word]: word }, host: { name: word, cpu: word, logical_cpus: 2 }, config_path: word,
      sessions: [{ argv: [word, "a b"], from_step: 0, started_utc: word, outcome: "" }],
      assumptions: [word], attributions: [word], inputs: [{ path: word, bytes: 3, sha256: word }] },
    history: { environment_exposure: 0.5, gain_errors: [null, 0.011], rounds, stages: [stage("start", 17), stage(word, 23)],
      parameters: [{ name: word, unit: word, num_scalars: 1, initial: 0.5, value: 0.1, minimum: 0.1, maximum: 0.1,
        rms_change: 0.4, standard_error: 0.02, lower_bound: 0.1, upper_bound: "inf", num_at_bound: 1, num_undetermined: 1, held: false }] },
    figures: {
      round: [figure("cost_total", { chart: "Cost" }), figure("spp", { chart: "Samples per pixel", by_stage: "max" }),
        figure("render_s", { unit: "s", label: "Images", by_stage: "sum" }), figure("linear_solver", { by_stage: "last" }),
        figure("new_figure", { unit: "m", chart: "A chart the script does not know" })],
      stage: ["stage", "rounds", "cost_before", "psnr_srgb_val_db", "iou_val", "stop_reason"].map((key) => figure(key)) },
    difference_scale: 0.2, views_note: word, config: word, resolved_config: word,
    views: [{ index: 0, pictures: { photo: "data:image/jpeg;base64,AA==", result: "data:image/jpeg;base64,BB==" } },
      { index: 1, pictures: {} }],
    environment: { initial: null, final: "data:image/png;base64,AA==" },
    model: someModel(word),
  };
}

function testAllSections(script) {
  const { main, links, title } = draw(script, someData());
  assert.deepStrictEqual(links, ["stages", "model", "views", "curves", "parameters", "exposure", "environment", "timing",
    "assumptions", "attribution", "reproduction"]);
  assert.strictEqual(title, "axe – pathfit report");
  assert.strictEqual(main.tagged("article").length, 2);
  assert.strictEqual(main.classed("none").length, 3 + 5, "pictures that are not there");
  assert.strictEqual(main.classed("plot").length, 3 + 2, "three charts, gains and times");
  assert.strictEqual(main.classed("cross").length, 1, "the rejected step");
  const gains = main.tagged("section").find((one) => one.attributes.id === "exposure");
  assert.ok(gains.textContent.includes("axe2: gain 1.1, 0.138 ± 0.014 EV"), gains.textContent);
  assert.ok(gains.textContent.includes("axe1: gain 1.1, 0.138 EV"), gains.textContent);
  assert.strictEqual(gains.classed("axis").length, 2, "the axis and the error of one gain");
  const words = main.textContent;
  for (const part of ["from 17.00 +6.00 dB", "20.00 → 20.00 dB", "[0.1, ∞]", "at bound", "not determined", "18446744073709551615",
    "axe 'a b'", "The others are in run.json", "A chart the script does not know"]) {
    assert.ok(words.includes(part), part);
  }
  const curves = main.classed("line");
  assert.strictEqual(curves.length, 2, "the figure that no round has is not drawn");
  assert.match(curves[0].attributes.d, /^M[\d.]+ [\d.]+L[\d.]+ [\d.]+L[\d.]+ [\d.]+$/);
}

function testNothing(script) {
  const data = someData();
  Object.assign(data.history, { rounds: [], stages: [], parameters: [] });
  Object.assign(data, { model: null, views: [], warnings: [], config: "", resolved_config: "", environment: { initial: null, final: null } });
  Object.assign(data.run, { wall_s: null, assumptions: [], attributions: [], inputs: [] });
  assert.deepStrictEqual(draw(script, data).links, ["reproduction"]);
}

function testHostileWords(script) {
  const nasty = "</script><img src=x onerror=alert(1)>\u0001";
  const { main } = draw(script, someData(nasty));
  assert.ok(main.textContent.includes(nasty), "shown as it is");
  assert.strictEqual(main.tagged("img").length, 3);
}

function testPicturesEnlargeInPlace(script) {
  const { main } = draw(script, someData());
  const [photo, result] = main.tagged("img");
  photo.listeners.click();
  result.listeners.keydown({ key: "Enter" });
  const zoomed = main.classed("zoomed");
  assert.strictEqual(zoomed.length, 1);
  assert.strictEqual(zoomed[0].src, result.src);
  zoomed[0].listeners.click();
  assert.strictEqual(main.classed("zoomed").length, 0);
}

function testSliderFadesFromPhotoToRenderingToDifference(script) {
  const data = someData();
  data.views[0].pictures.difference = "data:image/jpeg;base64,CC==";
  const { main } = draw(script, data);
  const article = main.tagged("article")[0];
  const slider = article.tagged("input")[0];
  assert.strictEqual(main.tagged("article")[1].tagged("input").length, 0, "nothing to fade between");
  const shown = () => article.classed("zoomed").map((image) => image.src.at(-3));
  for (const [at, sources, opacity] of [[0.25, "AB", "0.25"], [1.5, "BC", "0.5"], [2, "BC", "1"], [0, "AB", "0"]]) {
    slider.value = at;
    slider.listeners.input();
    assert.strictEqual(shown().join(""), sources);
    assert.strictEqual(article.classed("upper")[0].style.opacity, opacity);
  }
  article.tagged("img").find((image) => !image.classList.contains("zoomed")).listeners.click();
  assert.deepStrictEqual(shown(), ["A"], "a picture alone replaces the faded ones");
}

function testModelWithoutWebGl(script) {
  const { main, context } = draw(script, someData());
  const model = main.tagged("section").find((one) => one.attributes.id === "model");
  for (const part of ["WebGL is off or missing", "1 of 3 vertices", "1 triangles", "standard error of place", "metallic", "normals"]) {
    assert.ok(model.textContent.includes(part), part);
  }
  assert.ok(!model.textContent.includes("standard error of colour"), "which is not known");
  const data = someData();
  data.model = { start: null, result: null, note: "too large" };
  const empty = draw(script, data).main.tagged("section").find((one) => one.attributes.id === "model");
  assert.ok(empty.textContent.includes("too large") && empty.tagged("select").length === 0);
  const { start, result } = someModel("a");
  const whole = context.completed(start, result);
  assert.strictEqual(whole.meshes[0].triangles, result.meshes[0].triangles, "shared buffers are put back");
}

function testRampOfValues(script) {
  const { context } = draw(script, someData());
  const run = (text) => vm.runInContext(text, context);
  const shares = (key, values) => [...run(`(() => {
    const viewed = VIEWED.find((one) => one.key === "${key}");
    const values = Float32Array.from([${values}]);
    return rampShares(viewed, values, rampEnds(viewed, [values]));
  })()`)].map((share) => Math.round(share * 1000) / 1000);
  assert.deepStrictEqual(shares("position_error", "0.001, 0.01, 0.1, NaN, Infinity"), [0, 0.5, 1, -1, -3]);
  assert.deepStrictEqual(shares("position_error", "NaN, Infinity"), [-1, -3], "nothing but what is not known");
  assert.deepStrictEqual(shares("metallic", "0.25"), [0.25]);
  assert.deepStrictEqual(shares("photos", "0, 1, 4"), [0, 0.25, 1]);
  assert.deepStrictEqual(shares("photos", "0, 0"), [0, 0]);
  assert.ok(shares("position_error", "NaN, 0.02").every((share) => Number.isFinite(share)));
  assert.deepStrictEqual([...context.buffer(base64(Float32Array.from([1.5, -2])), Float32Array)], [1.5, -2]);
}

function testChartsEnlarge(script) {
  const { context } = draw(script, someData());
  const node = new Element(null, "div");
  node.append(context.linePlot({ title: "t", x: "x", y: "y", log: false, zero: false, marks: [], crosses: [],
    series: [{ name: "s", x: [0, 1, 2, 3, 4], y: [100, 1, 2, 1, 100] }] }));
  const ticks = () => node.classed("tick").map((tick) => tick.textContent);
  const drawing = () => node.tagged("svg")[0];
  const drag = (from, to) => {
    drawing().listeners.pointerdown({ clientX: from });
    drawing().listeners.pointermove({ clientX: to });
    drawing().listeners.pointerup({ clientX: to });
  };
  const whole = ticks();
  drag(150, 152);
  assert.deepStrictEqual(ticks(), whole, "a click is no drag");
  drag(400, 160); // 0.91 to 3.04 of 0 to 4
  assert.ok(!ticks().includes("100") && ticks().includes("2"), ticks().join());
  assert.strictEqual(node.tagged("svg").length, 2, "lines end at the frame");
  drawing().listeners.pointermove({ clientX: 280 });
  assert.strictEqual(node.classed("readout")[0].textContent, "x 2: s 2");
  drawing().listeners.dblclick();
  assert.deepStrictEqual(ticks(), whole);
  assert.strictEqual(node.tagged("svg").length, 1);
}

function testPlots(script) {
  const { context } = draw(script, someData());
  const plot = (x, y, log = false) => {
    const node = new Element(null, "div");
    node.append(context.linePlot({ title: "t", x: "x", y: "y", log, zero: false, series: [{ name: "s", x, y }],
      marks: [{ x: 0.5, label: "a" }, { x: NaN, label: "b" }, { x: 1e9, label: "c" }],
      crosses: [[1, 2], [NaN, 1], [1, -1]] }));
    for (const one of node.all()) {
      for (const [name, value] of Object.entries(one.attributes)) {
        assert.doesNotMatch(value, /NaN|Infinity|undefined/, `${one.tag} ${name}`);
        if (["x", "y", "cx", "cy"].includes(name)) assert.ok(Number(value) >= -1 && Number(value) <= 520, `${name} ${value}`);
      }
    }
    return node;
  };
  const empty = (node) => node.classed("empty").length === 1;
  const dots = (node) => node.classed("dot").length;
  for (const log of [false, true]) {
    assert.ok(empty(plot([], [], log)) && empty(plot([1, 2], [NaN, Infinity], log)));
    assert.strictEqual(dots(plot([3], [2], log)), 1, "a single point is a dot");
    assert.strictEqual(dots(plot([1, 2, 3], [NaN, 2, NaN], log)), 1);
    plot([1, 2], [1e-140, 1e140], log); // stays inside the picture
    plot([1, 1], [5, 5], log);
    plot([1e12, 1e12 + 1], [1e300, 1], log);
    plot([0, 1], [1, 1 + 1e-15], log);
  }
  assert.ok(empty(plot([1, 2], [0, 0], true)));
  assert.ok(!empty(plot([1, 2], [1, -1], true)), "what falls below zero stands on a linear axis");
  assert.strictEqual(dots(plot([1, 2, 3, 4, 5, 6], [1, 2, NaN, 4, 0, 6], true)), 2, "bad values interrupt the line");
  assert.strictEqual(dots(plot([1, 2, 3, 4], [1, Infinity, 3, 4])), 1);
  const many = Array.from({ length: 200000 }, (_, i) => i);
  const long = plot(many, many.map((x) => Math.sin(0.001 * x))).classed("line")[0].attributes.d;
  assert.ok(long.length < 60000, "long curves are thinned");
  const drawing = plot([1, 2], [3, 4]).tagged("svg")[0];
  drawing.listeners.pointermove({ clientX: 500 });
  assert.strictEqual(drawing.parent.classed("readout")[0].textContent, "x 2: s 4");
  drawing.listeners.pointerleave();
}

function testBars(script) {
  const { context } = draw(script, someData());
  const check = (node) => node.all().forEach((one) => Object.values(one.attributes).forEach((value) =>
    assert.doesNotMatch(value, /NaN|Infinity|undefined/)));
  check(context.bars({ title: "", x: "", y: "" }, [{ name: "a", value: NaN, color: 0 }, { name: "b", value: -3, color: 1 }]));
  assert.strictEqual(context.stackedBars("", "s", [], []).classed("empty").length, 1);
  assert.strictEqual(context.stackedBars("", "s", ["p"], [{ name: "x", values: [NaN, -1] }]).classed("empty").length, 1);
  const stacked = context.stackedBars("", "s", ["p", "q"], [{ name: "x", values: [1, 2, 3] }]);
  check(stacked);
  assert.strictEqual(stacked.tagged("rect").length, 3);
}

function testTicks(script) {
  const { context } = draw(script, someData());
  const linear = (...range) => [...context.linearTicks(...range)];
  const log = (...range) => [...context.logTicks(...range)];
  assert.deepStrictEqual(linear(0, 10, 5), [0, 2, 4, 6, 8, 10]);
  assert.strictEqual(linear(1, 1, 5).length, 1);
  assert.deepStrictEqual(log(0.9e-3, 1.1e1), [1e-3, 1e-2, 1e-1, 1, 10]);
  assert.ok(log(1.1, 1.3).length >= 2);
  assert.ok(log(1e-100, 1e100).length <= 12);
}

function testNumbers(script) {
  const { number, fixed, bytes, duration } = draw(script, someData()).context;
  const expected = new Map([[0, "0"], [-1.5, "−1.5"], [1e-5, "10⁻⁵"], [3.214e-6, "3.214·10⁻⁶"], [123456, "1.235·10⁵"],
    [12345, "12345"], [999.96, "1000"], [0.98765, "0.9877"], [NaN, "–"], [-Infinity, "−∞"]]);
  for (const [value, text] of expected) assert.strictEqual(number(value), text);
  assert.strictEqual(fixed(-0.001, 2, "dB"), "0.00 dB");
  assert.strictEqual(fixed(27.314, 2, "dB"), "27.31 dB");
  assert.strictEqual(bytes(812345), "813 kB");
  assert.strictEqual(bytes(3.44e6), "3.4 MB");
  assert.strictEqual(duration(12.34), "12.3 s");
  assert.strictEqual(duration(245), "4 min 05 s");
  assert.strictEqual(duration(7620), "2 h 07 min");
}

function testNewerDataReplaceWhatChanged(script) {
  const data = someData();
  const { main, context } = draw(script, data);
  const find = (id) => main.tagged("section").find((one) => one.attributes.id === id);
  const before = Object.fromEntries(["stages", "model", "views", "curves", "timing"].map((id) => [id, find(id)]));
  const newer = structuredClone(data);
  newer.history.rounds.push({ ...newer.history.rounds[2], step: 4, cost_total: 0.1 });
  context.draw(newer);
  for (const [id, node] of Object.entries(before)) {
    assert.strictEqual(find(id) === node, !["curves", "timing"].includes(id), id);
  }
  assert.ok(main.textContent.includes("4 rounds"));
  newer.history.parameters = [];
  newer.model = null;
  context.draw(newer);
  assert.ok(!find("parameters") && !find("model"));
  newer.model = someModel("later");
  context.draw(newer);
  assert.strictEqual(main.tagged("section").map((one) => one.attributes.id).indexOf("model"), 2, "in its place");
}

function testComparison(script) {
  const data = (word = "a") => ({
    columns: [{ key: "psnr_srgb_val_db", heading: "PSNR" }, { key: "rounds", heading: "Rounds" }],
    runs: [word, "b"].map((label, i) => ({ label, run_path: "/" + label, status: "finished", psnr_srgb_val_db: i ? null : 24.5,
      rounds: 7, history: [1, 2, 3].slice(i).map((step) => ({ step, wall_s: 2.5 * step, cost_total: 1 / step })) })),
    differences: [{ key: "seed", values: [word, "2"] }],
    figures: [figure("cost_total", { chart: "Cost" }), figure("iou_val", { chart: "IoU" })],
    views: [{ name: word, validation: true, photo: "data:image/jpeg;base64,AA==", results: [
      { photo: "data:image/jpeg;base64,CC==", picture: "data:image/jpeg;base64,BB==", psnr_srgb_db: 20, iou: 0.9 }, { picture: null, psnr_srgb_db: null, iou: null }] }],
    views_note: word });
  const { main, links } = draw(script, data());
  assert.deepStrictEqual(links, ["runs", "curves", "views", "settings"]);
  assert.strictEqual(main.classed("plot").length, 2, "cost over time and over steps; no run has the other figure");
  assert.strictEqual(main.classed("line").length, 4, "a line for each run");
  for (const part of ["24.50 dB", "–", "a: its photo", "a: 20.00 dB, IoU 0.9000", "not available", "seed"]) {
    assert.ok(main.textContent.includes(part), part);
  }
  const drawing = main.tagged("svg")[1];
  drawing.listeners.pointermove({ clientX: 500 });
  assert.strictEqual(drawing.parent.classed("readout")[0].textContent, "step 3: a 0.3333 · b 0.3333", "of each run its own");
  const nasty = "</script><img src=x onerror=alert(1)>";
  assert.ok(draw(script, data(nasty)).main.textContent.includes(nasty));
  const nothing = { ...data(), views: [], differences: [], figures: [] };
  assert.deepStrictEqual(draw(script, nothing).links, ["runs"]);
}

function testEvaluation(script) {
  const data = (word = "a") => ({
    evaluation: { run: "/" + word, truth: "/b", notes: [word] },
    tables: [{ key: "views", title: "Photos", note: word, columns: [
      { key: "view", unit: "", label: "View", doc: "" }, { key: "validation", unit: "", label: "Held out", doc: "" },
      { key: "psnr_srgb_db", unit: "dB", label: "PSNR", doc: word }, { key: "off_m", unit: "m", label: "Off", doc: "" }],
    rows: [{ view: word, validation: true, psnr_srgb_db: 24.5, off_m: 0.125 },
      { view: "c", validation: false, psnr_srgb_db: null, off_m: "inf" }] }],
    pictures: [{ title: word, tag: "relit", pictures: [
      { caption: "Truth", source: "data:image/jpeg;base64,AA==" }, { caption: "Result", source: "data:image/jpeg;base64,BB==" }] }] });
  const { main, links } = draw(script, data());
  assert.deepStrictEqual(links, ["views", "pictures", "notes"]);
  for (const part of ["/a against /b", "24.50 dB", "Off, m", "0.125", "yes", "–", "∞", "relit"]) {
    assert.ok(main.textContent.includes(part), part);
  }
  assert.strictEqual(main.tagged("img").length, 2);
  const nasty = "</script><img src=x onerror=alert(1)>";
  assert.ok(draw(script, data(nasty)).main.textContent.includes(nasty));
  const nothing = { evaluation: { run: "/a", truth: null, notes: [] }, tables: [], pictures: [] };
  assert.deepStrictEqual(draw(script, nothing).links, []);
}

function testCheck(script) {
  const view = (index, word) => ({ index, name: word, validation: index === 0, size: [40, 30], iou: index === 0 ? null : 0.875,
    covered: 0.25, pictures: { photo: "data:image/jpeg;base64,AA==" }, outline: "M1 2L3 4", mask: index === 0 ? "" : "M1 2L3 5",
    axes: [[[20, 15], [30, 15]], null, [[20, 15], [20, 15]]],
    lights: [{ name: word, at: [50, 10], arrow: [[20, 15], [30, 5]] }, { name: "sky", at: null, arrow: null },
      { name: "flash", at: [10, 10], arrow: null }] });
  const data = (word = "a") => ({
    check: { warnings: [word], assumptions: [word], meshes: [{ name: word, vertices: 8, triangles: 12 }], stages: [
      { name: word, unknowns: 24, image_scale: 0.5, max_rounds: 8, memory_bytes: 2.5e8, linear_solver: "cgnr", first_round_s: 4,
        likely_s: 65, most_s: 118 }, { name: "b", unknowns: 3, image_scale: 1, max_rounds: 2 }] },
    name: word, config_path: word, views: [view(0, word), view(1, word)], attributions: [word], config: word,
    lights: [{ name: word, kind: "point", frame: "world", place: "at [0, 1, 0]", photos: 1 }],
    parameters: [{ name: word, unit: "m", num_scalars: 3, initial: null, minimum: -1, maximum: 2, lower_bound: "-inf",
      upper_bound: 5, held: true }],
    environment: { initial: null, final: null }, model: { start: null, result: null, note: "too large" } });
  const { main, links, title } = draw(script, data());
  assert.deepStrictEqual(links, ["views", "model", "stages", "unknowns", "lights", "assumptions", "attribution", "config"]);
  assert.strictEqual(title, "a – pathfit check");
  for (const part of ["1 warning", "0.875", "250.0 MB", "65.0 s", "1 min 58 s", "held out", "at [0, 1, 0]", "1 of 2 photos", "[−∞, 5]",
    "held", "too large", "25.0 %"]) {
    assert.ok(main.textContent.includes(part), part);
  }
  const photos = main.classed("checked");
  assert.strictEqual(photos.length, 2);
  assert.strictEqual(photos[0].classed("mask").length, 0, "there is none");
  assert.strictEqual(photos[1].classed("mask").length, 1);
  assert.strictEqual(photos[0].classed("axis1").length, 0, "it is not seen");
  assert.strictEqual(photos[0].classed("lamp").length, 1, "one lies beside the picture");
  photos[0].tagged("svg")[0].listeners.click();
  assert.ok(photos[0].classList.contains("large"));
  const boxes = main.tagged("input");
  assert.strictEqual(boxes.length, 4);
  boxes[1].checked = false;
  boxes[1].listeners.change();
  assert.ok(main.classed("grid")[0].classList.contains("no-mask"));
  const nasty = "</script><img src=x onerror=alert(1)>";
  assert.ok(draw(script, data(nasty)).main.textContent.includes(nasty));
  const nothing = { ...data(), lights: [], parameters: [], model: null, attributions: [] };
  Object.assign(nothing.check, { warnings: [], stages: [], assumptions: [], meshes: [] });
  assert.deepStrictEqual(draw(script, nothing).links, ["views", "config"]);
  assert.ok(draw(script, nothing).main.textContent.includes("no objection"));
}

const script = fs.readFileSync(process.argv[2], "utf8") + fs.readFileSync(process.argv[3], "utf8");
for (const test of [testAllSections, testNothing, testHostileWords, testPicturesEnlargeInPlace,
  testSliderFadesFromPhotoToRenderingToDifference, testModelWithoutWebGl, testRampOfValues, testChartsEnlarge, testPlots, testBars,
  testTicks, testNumbers, testNewerDataReplaceWhatChanged, testComparison, testEvaluation, testCheck]) {
  test(script);
}
for (const path of process.argv.slice(4)) {
  const page = fs.readFileSync(path, "utf8");
  const part = (begin) => page.slice(page.indexOf(begin) + begin.length, page.indexOf("</script>", page.indexOf(begin)));
  draw(part("<script>"), JSON.parse(part('<script type="application/json" id="data">')));
}
console.log("the page draws");
