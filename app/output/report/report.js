// Draws the report of a run from the JSON in this page (app/output/report.cpp says what is in it). What comes from the
// run becomes text nodes and attributes, never markup.

// ---- elements

const SVG = "http://www.w3.org/2000/svg";

function make(namespace, tag, attributes, children) {
  const node = namespace ? document.createElementNS(namespace, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  const wanted = children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== "");
  node.append(...wanted.map((child) => (typeof child === "number" ? String(child) : child)));
  return node;
}
const h = (tag, attributes = {}, ...children) => make(null, tag, attributes, children);
const s = (tag, attributes = {}, ...children) => make(SVG, tag, attributes, children);
const section = (id, title, ...children) =>
  ({ id, title, node: h("section", { id }, h("h2", {}, title), ...children) });
const note = (...children) => h("p", { class: "note" }, ...children);

/** Columns are [heading, cell of a row, class]. */
function table(columns, rows) {
  const attributes = (column) => (column[2] ? { class: column[2] } : {});
  return h("table", {},
    h("thead", {}, h("tr", {}, columns.map((column) => h("th", attributes(column), column[0])))),
    h("tbody", {}, rows.map((row) =>
      h("tr", {}, columns.map((column) => h("td", attributes(column), column[1](row)))))));
}

// ---- numbers for people

/** JSON has no infinities and no NaN: they come as "inf", "-inf" and null. */
function num(value) {
  if (value === "inf") return Infinity;
  if (value === "-inf") return -Infinity;
  return typeof value === "number" ? value : typeof value === "boolean" ? Number(value) : NaN;
}

/** Four significant digits, powers of ten with superscripts. */
function number(value) {
  if (Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const sign = value < 0 ? "−" : "";
  const size = Math.abs(value);
  if (size === Infinity) return sign + "∞";
  if (size >= 999.95 && size < 99999.5) return sign + String(Math.round(size));
  if (size >= 1e-3 && size < 999.95) return sign + String(Number(size.toPrecision(4)));
  const [digits, exponent] = size.toExponential(3).split("e");
  const mantissa = String(Number(digits));
  const power = "10" + String(Number(exponent)).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)]));
  return sign + (mantissa === "1" ? power : mantissa + "·" + power);
}

/** Fixed digits after the point and a unit. */
function fixed(value, digits, unit = "") {
  if (!Number.isFinite(value)) return "–";
  const text = Math.abs(value).toFixed(digits);
  return (value < 0 && Number(text) !== 0 ? "−" : "") + text + (unit ? " " + unit : "");
}

function bytes(value) {
  if (!Number.isFinite(value)) return "–";
  if (value >= 999.5e6) return (value * 1e-9).toFixed(2) + " GB";
  if (value >= 999.5e3) return (value * 1e-6).toFixed(1) + " MB";
  return Math.ceil(value * 1e-3) + " kB";
}

function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 99.95) return Math.max(seconds, 0).toFixed(1) + " s";
  const total = Math.round(seconds);
  const two = (count) => String(count).padStart(2, "0");
  if (total < 3600) return `${Math.floor(total / 60)} min ${two(total % 60)} s`;
  return `${Math.floor(total / 3600)} h ${two(Math.floor(total / 60) % 60)} min`;
}

/** A figure's value as its unit says. */
function show(figure, value) {
  if (typeof value === "string" && !value.endsWith("inf")) return value;
  const v = num(value);
  if (figure.unit === "s") return duration(v);
  if (figure.unit === "MB") return bytes(v * 1e6);
  if (figure.unit === "dB") return fixed(v, 2, "dB");
  if (figure.unit === "IoU") return fixed(v, 4);
  return number(v);
}

/** "17.90 → 27.30 dB"; only the last value when there is no start. */
const change = (from, to, digits, unit) =>
  from === undefined ? fixed(num(to), digits, unit) : `${fixed(num(from), digits)} → ${fixed(num(to), digits, unit)}`;

/** Words as a shell takes them. */
function quoted(argv) {
  const plain = (word) => /^[^ \t\n"'$`\\*?[\]{}()<>|&;#~!]+$/.test(word);
  return argv.map((word) => (plain(word) ? word : `'${word.replaceAll("'", "'\\''")}'`)).join(" ");
}

// ---- charts

const px = (value) => Math.round(value * 10) / 10;

/** Round numbers that cover [low, high]. */
function linearTicks(low, high, about) {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span) || about < 1) return [low];
  const raw = span / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((nice) => nice * power >= raw * (1 - 1e-9)) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const ticks = [];
  for (let i = 0; (first + i) * step <= high + 1e-9 * span; ++i) ticks.push((first + i) * step);
  return ticks;
}

/** Of what is counted, between whole numbers there is nothing. */
function wholeIf(counted, ticks) {
  const whole = ticks.filter((tick) => Math.abs(tick - Math.round(tick)) < 1e-9);
  return counted && whole.length > 0 ? whole : ticks;
}

/** Powers of ten (and 2, 5 where there are few) in [low, high], both positive. */
function logTicks(low, high) {
  const first = Math.floor(Math.log10(low));
  const last = Math.ceil(Math.log10(high));
  const stride = Math.max(1, Math.floor((last - first) / 6));
  const ticks = [];
  for (let exponent = first; exponent <= last; exponent += stride) {
    for (const digit of last - first > 3 ? [1] : [1, 2, 5]) {
      const tick = Number(`${digit}e${exponent}`);
      if (tick >= low && tick <= high) ticks.push(tick);
    }
  }
  return ticks.length < 2 ? linearTicks(low, high, 4) : ticks;
}

/** Values beyond would make differences infinite. */
const drawable = (value, log) => Number.isFinite(value) && Math.abs(value) < 1e150 && (!log || value > 1e-150);

/** Maps [low, high] to [begin, end] of the picture. */
function axis(low, high, begin, end, log) {
  const f = log ? Math.log : (value) => value;
  return { low, high, log, at: (value) => begin + ((f(value) - f(low)) / (f(high) - f(low))) * (end - begin),
    value: (at) => low + ((at - begin) / (end - begin)) * (high - low) }; // of a linear axis
}

const FRAME = { width: 520, height: 250, left: 58, right: 508, top: 16, bottom: 212 };

/** Spreading a long list into Math.min would overflow the stack. */
const extent = (values) =>
  values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);

function xAxis(values) {
  const [low, high] = extent(values);
  const single = high - low < 1e-12 * Math.max(1, Math.abs(high));
  return axis(single ? low - 1 : low, single ? high + 1 : high, FRAME.left, FRAME.right, false);
}

function yAxis(values, { log, zero }) {
  const [low, high] = extent(values);
  if (log) {
    const decades = Math.log10(high) - Math.log10(low);
    const pad = 10 ** (0.5 * Math.max(0, 0.3 - decades) + 0.04 * decades); // a flat curve stands in the middle
    return axis(low / pad, high * pad, FRAME.bottom, FRAME.top, true);
  }
  const span = high - low;
  const pad = span > 1e-9 * Math.abs(high) ? 0.06 * span : 0.05 * Math.max(Math.abs(high), 0.2);
  return axis(zero && low >= 0 ? 0 : low - pad, high + pad, FRAME.bottom, FRAME.top, false);
}

const label = (x, y, css, text) => s("text", { class: css, x: px(x), y: px(y) }, text);
const turnedLabel = (x, y, text) =>
  s("text", { class: "label mid", transform: `translate(${x} ${px(y)}) rotate(-90)` }, text);

function grid(x, y, chart) {
  const { left, right, top, bottom, height } = FRAME;
  return [
    (y.log ? logTicks(y.low, y.high) : linearTicks(y.low, y.high, 5)).map((tick) => [
      s("path", { class: "grid", d: `M${left} ${px(y.at(tick))}H${right}` }),
      label(left - 6, y.at(tick) + 4, "tick end", number(tick))]),
    wholeIf(chart.x === "step", linearTicks(x.low, x.high, 6)).map((tick) => label(x.at(tick), bottom + 16, "tick mid", number(tick))),
    s("path", { class: "axis", d: `M${left} ${top}V${bottom}H${right}` }),
    label(0.5 * (left + right), height - 4, "label mid", chart.x),
    turnedLabel(12, 0.5 * (top + bottom), chart.y)];
}

/** Where stages begin; a name stands between its line and the next one if there is room. */
function markLines(x, marks) {
  const shown = marks.filter((mark) => drawable(mark.x, false) && mark.x <= x.high);
  return shown.map((mark, i) => {
    const at = Math.max(x.at(mark.x), FRAME.left);
    const end = i + 1 < shown.length ? Math.min(x.at(shown[i + 1].x), FRAME.right) : FRAME.right;
    return [
      at > FRAME.left + 0.5 ? s("path", { class: "stage", d: `M${px(at)} ${FRAME.top}V${FRAME.bottom}` }) : null,
      6.2 * mark.label.length < end - at ? label(at + 3, FRAME.top - 4, "tick", mark.label) : null];
  });
}

/** A line with gaps where there is nothing to draw; a point alone is a dot. */
function curve(x, y, series, color) {
  const stride = Math.floor(series.x.length / 2000) + 1;
  let path = "";
  let length = 0;
  let point = null;
  const dots = [];
  const endRun = () => {
    if (length === 1) dots.push(s("circle", { class: `dot s${color}`, cx: point[0], cy: point[1], r: 2.6 }));
    length = 0;
  };
  series.x.forEach((step, i) => {
    if (i % stride !== 0 && i + 1 !== series.x.length) return;
    if (!drawable(step, false) || !drawable(series.y[i], y.log)) return endRun();
    point = [px(x.at(step)), px(y.at(series.y[i]))];
    path += `${length === 0 ? "M" : "L"}${point[0]} ${point[1]}`;
    ++length;
  });
  endRun();
  return [path ? s("path", { class: `line s${color}`, d: path }) : null, dots];
}

/** Shows the values under the pointer; what is dragged over becomes the whole axis, until a double click. */
function addReadout(readout, drawing, chart, state) {
  const cursor = s("path", { class: "cursor" });
  const band = s("rect", { class: "band", x: 0, y: FRAME.top, width: 0, height: FRAME.bottom - FRAME.top });
  drawing.append(band, cursor);
  const where = (event) => {
    const box = drawing.getBoundingClientRect();
    return Math.min(Math.max(((event.clientX - box.left) / box.width) * FRAME.width, FRAME.left), FRAME.right);
  };
  const hint = () => (state.range ? "double click: all of it" : " ");
  let from = null;
  drawing.addEventListener("pointerdown", (event) => { from = where(event); });
  drawing.addEventListener("pointermove", (event) => {
    const { x } = state;
    const at = where(event);
    if (from !== null) {
      band.setAttribute("x", px(Math.min(from, at)));
      band.setAttribute("width", px(Math.abs(at - from)));
    }
    const nearestIn = (one) => one.x.reduce((best, step, i) =>
      (Math.abs(x.at(step) - at) < Math.abs(x.at(one.x[best]) - at) ? i : best), 0);
    const steps = chart.series[0].x;
    const nearest = nearestIn(chart.series[0]);
    cursor.setAttribute("d", `M${px(x.at(steps[nearest]))} ${FRAME.top}V${FRAME.bottom}`);
    const values = chart.series.map((one) => `${one.name} ${number(one.y[nearestIn(one)])}`);
    readout.textContent = `${chart.x} ${number(steps[nearest])}: ${values.join(" · ")}`;
  });
  drawing.addEventListener("pointerup", (event) => {
    if (from === null) return;
    const ends = [from, where(event)].sort((a, b) => a - b).map(state.x.value);
    const far = Math.abs(where(event) - from) > 8;
    from = null;
    if (far) state.zoom(ends);
  });
  drawing.addEventListener("dblclick", () => state.range && state.zoom(null));
  drawing.addEventListener("pointerleave", () => {
    from = null;
    band.setAttribute("width", 0);
    cursor.setAttribute("d", "");
    readout.textContent = hint();
  });
  readout.textContent = hint();
}

/**
 * chart: title, x and y (labels), log, zero (start the axis at 0), marks [{x, label}], crosses [[x, y]] and
 * series [{name, doc, x, y}], whose points that are not finite (or not positive on a log axis) interrupt the line.
 */
function linePlot(given) {
  // Costs may fall below zero (log-determinants, variances taken off), which no log scale shows.
  const log = given.log && !given.series.some((one) => one.y.some((value) => value < 0));
  const chart = { ...given, log, y: given.log && !log ? given.y.replace(", log scale", "") : given.y };
  const keys = chart.series.length < 2 ? [] : chart.series.map((one, i) =>
    h("span", { class: `key s${i % 6}`, title: one.doc ?? "" }, one.name));
  if (chart.crosses.length > 0) keys.push(h("span", { class: "key reject" }, "✕ rejected step"));
  const figure = h("figure", { class: "plot" }, h("figcaption", {}, h("b", {}, chart.title), keys));
  const points = chart.series.flatMap((one) => one.x.map((step, i) => [step, one.y[i]]));
  const inside = ([a, b]) => drawable(a, false) && drawable(b, chart.log);
  if (!points.some(inside)) {
    figure.append(h("p", { class: "empty" }, "No data."));
    return figure;
  }
  const crosses = chart.crosses.filter(inside);
  const all = [...points.filter(inside), ...crosses];
  const readout = h("span", { class: "readout", title: "Drag over a part of the chart to enlarge it" }, " ");
  figure.firstChild.append(readout);
  const state = { range: null, x: null, zoom: null };
  const drawn = (range) => {
    const within = ([a]) => !range || (a >= range[0] && a <= range[1]);
    // Neighbours of the range keep lines going to its borders, and count for the height only if nothing is inside.
    const shown = all.filter(within);
    state.range = range;
    state.x = xAxis(range ?? all.map((point) => point[0]));
    const x = state.x;
    const y = yAxis((shown.length > 0 ? shown : all).map((point) => point[1]), chart);
    const { left, right, top, bottom } = FRAME;
    // A drawing inside a drawing ends at its border.
    const [width, height] = [right - left, bottom - top + 8];
    const part = { x: left, y: top - 4, width, height, viewBox: `${left} ${top - 4} ${width} ${height}` };
    const drawing = s("svg", { viewBox: `0 0 ${FRAME.width} ${FRAME.height}`, role: "img", "aria-label": chart.title },
      grid(x, y, chart), markLines(x, chart.marks),
      s(range ? "svg" : "g", range ? part : {},
        chart.series.map((one, i) => curve(x, y, one, i % 6)),
        crosses.filter(within).map(([a, b]) =>
          s("path", { class: "cross", d: `M${px(x.at(a) - 4)} ${px(y.at(b) - 4)}l8 8m0 -8l-8 8` }))));
    addReadout(readout, drawing, chart, state);
    return drawing;
  };
  let drawing = drawn(null);
  state.zoom = (range) => {
    const next = drawn(range);
    drawing.before(next);
    drawing.remove();
    drawing = next;
  };
  figure.append(drawing);
  return figure;
}

const WIDE = { width: 1060, left: 58, right: 1048 };
const bar = (x, y, width, height, color, tooltip) => s("rect",
  { class: `bar s${color}`, x: px(x), y: px(y), width: px(Math.max(width, 0)), height: px(Math.max(height, 0)) },
  s("title", {}, tooltip));
const finite = (value) => (Number.isFinite(value) ? value : 0);

/** Vertical bars from zero; groups [{name, value, color}]. */
function bars(chart, groups) {
  const figure = h("figure", { class: "plot wide" }, h("figcaption", {}, h("b", {}, chart.title)));
  const values = groups.map((group) => 1.1 * finite(group.value));
  const y = axis(Math.min(-0.1, ...values), Math.max(0.1, ...values), 176, 10, false);
  const pitch = (WIDE.right - WIDE.left) / groups.length;
  figure.append(s("svg", { viewBox: `0 0 ${WIDE.width} 200`, role: "img", "aria-label": chart.title },
    linearTicks(y.low, y.high, 4).map((tick) => [
      s("path", { class: "grid", d: `M${WIDE.left} ${px(y.at(tick))}H${WIDE.right}` }),
      label(WIDE.left - 6, y.at(tick) + 4, "tick end", number(tick))]),
    groups.map((group, i) => {
      const at = y.at(finite(group.value));
      const left = WIDE.left + (i + 0.1) * pitch;
      const width = Math.min(0.8 * pitch, 60);
      const whisker = Number.isFinite(group.error) && s("path", { class: "axis",
        d: `M${px(left + 0.5 * width)} ${px(y.at(group.value - group.error))}V${px(y.at(group.value + group.error))}` });
      return [bar(left, Math.min(y.at(0), at), width, Math.max(Math.abs(at - y.at(0)), 0.5), group.color, group.name),
        whisker || []];
    }),
    s("path", { class: "axis", d: `M${WIDE.left} ${px(y.at(0))}H${WIDE.right}` }),
    label(0.5 * (WIDE.left + WIDE.right), 194, "label mid", chart.x), turnedLabel(12, 93, chart.y)));
  return figure;
}

/** Horizontal stacked bars; parts are names, groups [{name, values}] with values >= 0. */
function stackedBars(title, unit, parts, groups) {
  const keys = parts.map((part, k) => h("span", { class: `key s${k % 6}` }, part));
  const figure = h("figure", { class: "plot wide" }, h("figcaption", {}, h("b", {}, title), keys));
  const lengths = groups.map((group) => group.values.map((value) => Math.max(finite(value), 0)));
  const longest = Math.max(0, ...lengths.map((values) => values.reduce((a, b) => a + b, 0)));
  if (!(longest > 0)) {
    figure.append(h("p", { class: "empty" }, "No data."));
    return figure;
  }
  const rowHeight = 30;
  const left = 130;
  const scale = (WIDE.right - left) / longest;
  const rows = groups.map((group, i) => {
    const y = rowHeight * i + 4;
    let x = left;
    return [label(left - 8, y + 16, "tick end", group.name), lengths[i].map((value, k) => {
      x += scale * value;
      const tooltip = `${parts[k] ?? ""}: ${number(value)} ${unit}`;
      return bar(x - scale * value, y, scale * value, rowHeight - 8, k % 6, tooltip);
    })];
  });
  const height = rowHeight * groups.length + 4;
  figure.append(s("svg", { viewBox: `0 0 ${WIDE.width} ${height}`, role: "img", "aria-label": title }, rows));
  return figure;
}

// ---- sections; each returns null when there is nothing to show

const lastStage = (data) => data.history.stages.at(-1);
/** Entry of the start of the run, unless it is all there is. */
const startStage = (data) => data.history.stages.slice(0, -1).find((stage) => stage.stage === "start");

function header(data) {
  const { run } = data;
  const ended = run.ended_utc ? " · ended " + run.ended_utc : "";
  return h("header", {}, h("h1", {}, run.name),
    h("p", { class: "sub" }, `${data.run_path} · started ${run.started_utc}${ended}`));
}

function tile(title, value, ...below) {
  return h("div", { class: "tile" }, h("span", {}, title), h("b", {}, value), h("span", {}, below));
}

function verdict(data) {
  const last = lastStage(data);
  const start = startStage(data);
  const quality = (title, key, digits, unit) => {
    const value = num(last?.[key]);
    if (!Number.isFinite(value)) return null;
    const before = num(start?.[key]);
    if (!Number.isFinite(before)) return tile(title, fixed(value, digits, unit));
    const gain = value - before;
    return tile(title, fixed(value, digits, unit), `from ${fixed(before, digits)} `,
      h("i", { class: gain < 0 ? "down" : "up" }, (gain > 0 ? "+" : "") + fixed(gain, digits, unit)));
  };
  const rounds = data.history.rounds.at(-1);
  const wall = num(data.run.wall_s) > 0 ? num(data.run.wall_s) : num(rounds?.wall_s ?? 0);
  return h("section", { class: "card verdict " + data.status },
    h("span", { class: "badge" }, data.status), h("p", {}, data.sentence),
    h("div", { class: "tiles" },
      quality("Held-out views, PSNR (sRGB)", "psnr_srgb_val_db", 2, "dB"),
      quality("Held-out views, mask IoU", "iou_val", 4, ""),
      quality("Fitted views, PSNR (sRGB)", "psnr_srgb_fit_db", 2, "dB"),
      quality("Fitted views, mask IoU", "iou_fit", 4, ""),
      tile("Wall time", duration(wall), rounds ? `${rounds.step} rounds` : "")),
    data.warnings.length === 0 ? null
      : h("ul", { class: "warnings" }, data.warnings.map((warning) => h("li", {}, warning))));
}

function stagesSection(data) {
  const { stages } = data.history;
  if (stages.length === 0) return null;
  const columns = data.figures.stage.map((figure) => [
    h("span", { title: figure.doc }, figure.label),
    (stage) => (num(stage.rounds) === 0 && figure.key.startsWith("cost") ? "–" : show(figure, stage[figure.key])),
    figure.key === "stop_reason" ? "left wrap" : ""]);
  return section("stages", "Stages", h("div", { class: "card scroll" }, table(columns, stages),
    note("PSNR is measured inside the mask, after the sRGB curve or on linear values as named; means over views. " +
      "Costs before and after a stage use the same samples.")));
}

/** Pictures of one view appear large in the same place, so that going from one to the next shows what differs. */
function showLarge(row, image) {
  const zoom = largeAbove(row);
  zoom.firstChild.src = image.src;
  zoom.firstChild.alt = image.alt;
  zoom.children[1]?.remove(); // what the slider laid over it
}

/** Where large pictures of a row are. */
function largeAbove(row) {
  let zoom = row.previousElementSibling;
  if (!zoom?.classList.contains("zoom")) {
    const large = h("img", { class: "zoomed" });
    zoom = h("div", { class: "zoom" }, large);
    large.addEventListener("click", () => zoom.remove());
    row.before(zoom);
  }
  return zoom;
}

/** Large pictures [{name, source}] that a slider fades from one to the next. */
function fader(row, pictures) {
  const slider = h("input", { type: "range", min: 0, max: pictures.length - 1, step: 0.02, value: 0,
    "aria-label": pictures.map(({ name }) => name).join(", ") });
  slider.addEventListener("input", () => {
    const zoom = largeAbove(row);
    const at = Number(slider.value);
    const lower = Math.min(Math.floor(at), pictures.length - 2);
    let upper = zoom.children[1];
    if (!upper) {
      upper = h("img", { class: "zoomed upper" });
      zoom.append(upper);
    }
    const set = (image, { name, source }) => {
      if (image.src !== source) image.src = source;
      image.alt = name;
    };
    set(zoom.firstChild, pictures[lower]);
    set(upper, pictures[lower + 1]);
    upper.style.opacity = String(at - lower);
  });
  return h("label", { class: "fader" }, h("span", {}, pictures[0].name), slider,
    h("span", {}, pictures.slice(1).map(({ name }) => name).join(" · ")));
}

function picture(row, caption, alt, source) {
  const title = "Click to enlarge; click another one to compare in place";
  const image = source ? h("img", { alt, src: source, tabindex: 0, title })
    : h("div", { class: "none" }, "not available");
  if (source) {
    image.addEventListener("click", () => showLarge(row, image));
    image.addEventListener("keydown", (event) => event.key === "Enter" && showLarge(row, image));
  }
  row.append(h("figure", {}, image, h("figcaption", {}, caption)));
}

function viewArticle(data, { index, pictures }) {
  const view = lastStage(data).views[index];
  const before = startStage(data)?.views[index];
  const row = h("div", { class: "row" });
  picture(row, "Photo", "photo " + view.name, pictures.photo);
  picture(row, "Start", "start, " + view.name, pictures.start);
  picture(row, "After " + lastStage(data).stage, "result, " + view.name, pictures.result);
  picture(row, "Difference", "difference, " + view.name, pictures.difference);
  picture(row, "Silhouette", "silhouette, " + view.name, pictures.silhouette);
  const numbers = [
    "PSNR sRGB " + change(before?.psnr_srgb_db, view.psnr_srgb_db, 2, "dB"),
    "linear " + change(before?.psnr_linear_db, view.psnr_linear_db, 2, "dB"),
    "IoU " + change(before?.iou, view.iou, 4),
    "gain " + number(num(view.gain))];
  const faded = [["photo", "photo"], ["result", "rendering"], ["difference", "difference"]].flatMap(([kind, name]) =>
    (pictures[kind] ? [{ name, source: pictures[kind] }] : []));
  return h("article", { class: "card view", id: "view" + index },
    h("div", { class: "head" }, h("h3", {}, view.name),
      view.validation ? h("span", { class: "tag val" }, "held out") : h("span", { class: "tag" }, "fitted"),
      h("span", { class: "numbers" }, numbers.join(" · ")), faded.length > 1 ? fader(row, faded) : null), row);
}

function viewsSection(data) {
  if (!lastStage(data)?.views.length) return null;
  const swatch = (kind, text) => [h("i", { class: "sw " + kind }), text];
  return section("views", "Views", h("div", { class: "card" },
    h("p", { class: "scale" }, h("span", {}, "Difference, rendered − photo, mean of the sRGB-encoded channels:"),
      h("span", {}, "−" + data.difference_scale), h("span", { class: "ramp" }),
      h("span", {}, "+" + data.difference_scale),
      h("span", {}, "(range 0…1; blue: too dark, red: too bright, grey: not compared)")),
    h("p", { class: "scale" }, h("span", {}, "Silhouette:"), h("span", {}, swatch("both", "object in both"),
      swatch("fit", "only rendered"), swatch("mask", "only in the mask"))),
    note(data.views_note)), data.views.map((view) => viewArticle(data, view)));
}

/** How charts of rounds differ from a plain one, in their order; others follow, with the unit of their figures. */
const CHARTS = {
  "Cost": { y: "cost, log scale", log: true, crosses: true },
  "PSNR inside the mask, linear values": {},
  "Mask IoU": { y: "IoU" },
  "Step length": { y: "norm, log scale", log: true },
  "Samples per pixel": { y: "spp", zero: true },
  "Sampling noise in the residual": { y: "share of rms residual", zero: true },
};

function curvesSection(data) {
  const { rounds } = data.history;
  if (rounds.length === 0) return null;
  const steps = rounds.map((round) => num(round.step));
  const marks = [];
  rounds.forEach((round, i) => {
    if (i === 0 || round.stage !== rounds[i - 1].stage) marks.push({ x: steps[i] - 0.5, label: round.stage });
  });
  const rejected = rounds.filter((round) => !round.accepted).map((round) => [num(round.step), num(round.cost_total)]);
  const drawn = data.figures.round.filter((figure) => figure.chart);
  const titles = new Set(drawn.map((figure) => figure.chart));
  const ordered = [...Object.keys(CHARTS).filter((title) => titles.has(title)), ...titles];
  const charts = [...new Set(ordered)].flatMap((title) => {
    const given = CHARTS[title] ?? {};
    const group = drawn.filter((figure) => figure.chart === title);
    const series = group.map((figure) => (
      { name: figure.label, doc: figure.doc, x: steps, y: rounds.map((round) => num(round[figure.key])) }));
    if (series.every((one) => one.y.every((value) => value === 0))) return []; // nothing of it happened
    const known = series.filter((one) => one.y.some((value) => drawable(value, given.log && !(value < 0))));
    return linePlot({ title, x: "step", y: given.y ?? group[0].unit, log: given.log ?? false, zero: given.zero ?? false,
      marks, crosses: given.crosses ? rejected : [], series: known.length > 0 ? known : series });
  });
  return section("curves", "Curves", h("div", { class: "plots" }, charts),
    note("Every round has its own samples, so costs of neighbouring rounds differ by noise as well. Dotted lines: " +
      "beginnings of stages. Drag over a part of a chart to enlarge it; a double click shows all again."));
}

function parametersSection(data) {
  const { parameters } = data.history;
  if (parameters.length === 0) return null;
  const many = (p) => p.num_scalars > 1;
  const bounds = (p) => {
    const [lower, upper] = [num(p.lower_bound), num(p.upper_bound)];
    return Number.isFinite(lower) || Number.isFinite(upper) ? `[${number(lower)}, ${number(upper)}]` : "none";
  };
  const state = (p) => {
    if (p.held) return h("span", { class: "tag" }, "held");
    const count = (number, words) => (number > 0
      ? h("span", { class: "tag bound" }, many(p) ? `${number} ${words}` : words) : "");
    return h("span", {}, count(p.num_at_bound, "at bound"), count(p.num_undetermined, "not determined"));
  };
  const columns = [["Name", (p) => p.name], ["Unit", (p) => p.unit], ["Scalars", (p) => p.num_scalars],
    ["Initial", (p) => number(num(p.initial))], ["Final", (p) => number(num(p.value))],
    ["Standard error", (p) => (Number.isFinite(num(p.standard_error)) ? number(num(p.standard_error)) : "")],
    ["Range", (p) => (many(p) ? `${number(num(p.minimum))} … ${number(num(p.maximum))}` : "")],
    ["RMS change", (p) => number(num(p.rms_change))], ["Bounds", bounds], ["", state]];
  return section("parameters", "Parameters", h("div", { class: "card scroll" }, table(columns, parameters),
    note("Groups of many scalars show their mean, the median of their standard errors, range and root mean square change. No photo tells what is " +
      "not determined: it may lie anywhere between its bounds."),
    data.run.gauge ? note(data.run.gauge.sentence) : null));
}

function exposureSection(data) {
  const views = lastStage(data)?.views ?? [];
  if (views.length === 0) return null;
  const errors = data.history.gain_errors ?? [];
  const groups = views.map((view, i) => {
    const gain = num(view.gain);
    const ev = gain > 0 ? Math.log2(gain) : 0;
    const error = gain > 0 ? num(errors[i]) / (gain * Math.LN2) : NaN;
    const spread = Number.isFinite(error) ? ` ± ${error.toPrecision(2)}` : "";
    return { name: `${view.name}: gain ${number(gain)}, ${fixed(ev, 3)}${spread} EV`, value: ev, error,
      color: view.validation ? 1 : 0 };
  });
  return section("exposure", "Exposure",
    bars({ title: "Gain of each photo", x: "photos in order", y: "EV (log2 gain)" }, groups),
    note(h("i", { class: "sw s0" }), "fitted ", h("i", { class: "sw s1" }), "held out. The gain multiplies the " +
      "rendered radiance; upright lines are standard errors; numbers are in result/exposure.csv."));
}

function environmentSection(data) {
  const { initial, final } = data.environment;
  if (!final) return null;
  const exposure = num(data.history.environment_exposure);
  const shown = [["Initial", initial], ["Final", final]].filter(([, source]) => source);
  return section("environment", "Environment light", h("div", { class: "card" },
    h("div", { class: "pair" }, shown.map(([caption, source]) =>
      h("figure", {}, h("img", { alt: "environment, " + caption, src: source }), h("figcaption", {}, caption)))),
    note("Latitude and longitude in the light's own frame, top is +y, the left edge and the right edge look along " +
      `−z; values times ${number(exposure)} (${fixed(Math.log2(exposure), 2, "EV")}), the same for both, then the ` +
      "sRGB curve.")));
}

/** Rounds of each stage put together as each figure's by_stage says: sum, largest or last. */
function timesByStage(rounds, figures) {
  const stages = [];
  let wall = 0;
  for (const round of rounds) {
    if (stages.at(-1)?.stage !== round.stage) stages.push({ stage: round.stage, rounds: 0, wall_s: 0 });
    const times = stages.at(-1);
    times.rounds += 1;
    times.wall_s += Math.max(finite(num(round.wall_s) - wall), 0);
    wall = num(round.wall_s);
    for (const { key, by_stage } of figures) {
      const value = round[key];
      times[key] = !(key in times) || by_stage === "last" ? value
        : by_stage === "sum" ? num(times[key]) + num(value) : Math.max(num(times[key]), num(value));
    }
  }
  return stages;
}

function timingSection(data) {
  const figures = data.figures.round.filter((figure) => figure.by_stage);
  const stages = timesByStage(data.history.rounds, figures);
  if (stages.length === 0) return null;
  const summed = figures.filter((figure) => figure.by_stage === "sum");
  const groups = stages.map((times) => {
    const values = summed.map((figure) => num(times[figure.key]));
    const known = values.reduce((a, b) => a + finite(b), 0);
    return { name: times.stage, values: [...values, Math.max(times.wall_s - known, 0)] };
  });
  const columns = [["Stage", (times) => times.stage], ["Rounds", (times) => times.rounds],
    ["Wall", (times) => duration(times.wall_s)], ["Per round", (times) => duration(times.wall_s / times.rounds)],
    ...figures.map((figure) =>
      [h("span", { title: figure.doc }, figure.label), (times) => show(figure, times[figure.key])])];
  return section("timing", "Time and memory",
    stackedBars("Seconds by stage", "s", [...summed.map((figure) => figure.label), "other"], groups),
    h("div", { class: "card scroll" }, table(columns, stages)));
}

function listSection(id, title, items) {
  if (items.length === 0) return null;
  return section(id, title, h("div", { class: "card" },
    h("ul", { class: "plain" }, items.map((item) => h("li", {}, item)))));
}

function reproductionSection(data) {
  const { run } = data;
  const rows = [
    ["Program", `pathfit ${run.program_version}, ${run.build}`],
    ["Libraries", Object.entries(run.libraries).map(([name, version]) => `${name} ${version}`).join(", ")],
    ["Machine",
      `${run.host.name}, ${run.host.cpu}, ${run.host.logical_cpus} logical CPUs, ${run.threads} threads used`],
    ["Seed", data.seed],
    ["Configuration", run.config_path],
    ...run.sessions.map((session) => [session.from_step === 0 ? "Command" : "From step " + session.from_step,
      `${quoted(session.argv)}  (${session.started_utc}${session.outcome ? ", " + session.outcome : ""})`])];
  const file = (title, text) => (text ? h("details", {}, h("summary", {}, title), h("pre", {}, text)) : null);
  const columns = [["File", (input) => input.path, "wrap"], ["Size", (input) => bytes(input.bytes)],
    ["SHA-256", (input) => h("code", {}, input.sha256), "left"]];
  const inputs = run.inputs.length === 0 ? null : h("details", {},
    h("summary", {}, `Input files and their SHA-256 (${data.num_inputs})`),
    h("div", { class: "scroll" }, table(columns, run.inputs)),
    run.inputs.length < data.num_inputs ? note("The others are in run.json.") : null);
  return section("reproduction", "Reproduction", h("div", { class: "card" },
    h("div", { class: "scroll" }, h("table", {}, h("tbody", {}, rows.map(([name, value]) =>
      h("tr", {}, h("td", {}, name), h("td", { class: "left wrap" }, value)))))),
    file("config.yaml, as given", data.config), file("config.resolved.yaml, every value", data.resolved_config),
    inputs));
}

/** What makes each section, and the part of the data that it shows. */
const SECTIONS = [
  [stagesSection, (data) => data.history.stages],
  [modelSection, (data) => [data.model, data.environment.final, data.views]],
  [viewsSection, (data) => [data.views, data.views_note, startStage(data), lastStage(data)]],
  [curvesSection, (data) => data.history.rounds],
  [parametersSection, (data) => [data.history.parameters, data.run.gauge]],
  [exposureSection, (data) => [data.history.gain_errors, lastStage(data)]],
  [environmentSection, (data) => [data.environment, data.history.environment_exposure]],
  [timingSection, (data) => data.history.rounds],
  [(data) => listSection("assumptions", "Assumptions", data.run.assumptions), (data) => data.run.assumptions],
  [(data) => listSection("attribution", "Attribution", data.run.attributions), (data) => data.run.attributions],
  [reproductionSection, (data) => [data.run.sessions, data.run.inputs, data.config]]];
const drawnSections = []; // in the order of SECTIONS: {shown, one}

/** Draws the page, or, of newer data of the same run, what has changed. */
function draw(data) {
  const started = [];
  SECTIONS.forEach(([make, part], i) => {
    const shown = JSON.stringify(part(data));
    const before = drawnSections[i];
    if (before?.shown === shown) return;
    const one = make(data);
    drawnSections[i] = { shown, one };
    if (one?.start) started.push([one, before?.one?.kept?.()]);
  });
  const sections = drawnSections.map(({ one }) => one).filter((one) => one);
  const main = document.querySelector("main");
  const scrolled = globalThis.scrollY ?? 0;
  document.title = data.run.name + " – pathfit report";
  main.replaceChildren(header(data), verdict(data),
    h("nav", { "aria-label": "Sections" }, sections.map((one) => h("a", { href: "#" + one.id }, one.title))),
    ...sections.map((one) => one.node));
  started.forEach(([one, kept]) => one.start(kept)); // what needs its size
  if (scrolled > 0) scrollTo(0, scrolled);
}

// ---- several runs on one page (app/output/comparison.cpp)

const COMPARED = [
  { along: "wall_s", x: "time, s", keys: ["cost_total", "psnr_linear_val_db", "psnr_linear_fit_db", "iou_val"] },
  { along: "step", x: "step", keys: ["cost_total", "psnr_linear_val_db", "psnr_linear_fit_db", "iou_val"] }];

function comparedRunsSection(data) {
  const units = { wall_s: "s", peak_rss_mb: "MB", iou_val: "IoU", iou_fit: "IoU" };
  const columns = [["Run", (run) => [h("b", {}, run.label), h("br"), h("span", { class: "note" }, run.run_path)], "wrap"],
    ["Status", (run) => run.status],
    ...data.columns.map(({ key, heading }) => [heading, (run) =>
      show({ unit: units[key] ?? (key.endsWith("_db") ? "dB" : "") }, run[key])])];
  return section("runs", "Runs", h("div", { class: "card scroll" }, table(columns, data.runs),
    note("Of each run's last stage. PSNR is measured inside the mask, after the sRGB curve; – where there is no mask, or " +
      "no held-out photo.")));
}

function comparedViewsSection(data) {
  if (data.views.length === 0) return null;
  const articles = data.views.map((view) => {
    const row = h("div", { class: "row" });
    picture(row, "Photo", "photo " + view.name, view.photo);
    view.results.forEach((result, i) => {
      const words = `${data.runs[i].label}: ${fixed(num(result.psnr_srgb_db), 2, "dB")}, IoU ${fixed(num(result.iou), 4)}`;
      if (result.photo) picture(row, `${data.runs[i].label}: its photo`, "photo " + view.name, result.photo);
      picture(row, words, data.runs[i].label + ", " + view.name, result.picture);
    });
    return h("article", { class: "card view" }, h("div", { class: "head" }, h("h3", {}, view.name),
      view.validation ? h("span", { class: "tag val" }, "held out") : null), row);
  });
  return section("views", "Views", note(data.views_note), articles);
}

function comparedCurvesSection(data) {
  const charts = COMPARED.flatMap(({ along, x, keys }) => keys.flatMap((key) => {
    const figure = data.figures.find((one) => one.key === key);
    const series = data.runs.map((run) => ({ name: run.label, doc: run.run_path,
      x: run.history.map((round) => num(round[along])), y: run.history.map((round) => num(round[key])) }));
    const log = key === "cost_total";
    if (!figure || !series.some((one) => one.y.some((value) => drawable(value, log && !(value < 0))))) return [];
    return [linePlot({ title: `${figure.chart}, ${figure.label}`, x, y: figure.unit, log, zero: false, marks: [],
      crosses: [], series: series.filter((one) => one.x.length > 0) })];
  }));
  return charts.length === 0 ? null : section("curves", "Curves", h("div", { class: "plots" }, charts));
}

function differencesSection(data) {
  if (data.differences.length === 0) return null;
  const columns = [["Setting", (row) => h("code", {}, row.key), "wrap"],
    ...data.runs.map((run, i) => [run.label, (row) => row.values[i], "wrap"])];
  return section("settings", "Settings that differ", h("div", { class: "card scroll" }, table(columns, data.differences)));
}

function drawComparison(data) {
  const sections = [comparedRunsSection(data), comparedCurvesSection(data), comparedViewsSection(data),
    differencesSection(data)].filter((one) => one);
  document.title = "pathfit comparison";
  document.querySelector("main").append(
    h("header", {}, h("h1", {}, "Comparison"), h("p", { class: "sub" }, data.runs.map((run) => run.label).join(" · "))),
    h("nav", { "aria-label": "Sections" }, sections.map((one) => h("a", { href: "#" + one.id }, one.title))),
    ...sections.map((one) => one.node));
}

// ---- a result against photos and truth (app/output/evaluation.cpp)

function evaluationCell({ key, unit }, row) {
  const value = row[key];
  if (typeof value === "boolean") return value ? "yes" : "";
  if (typeof value === "string" && !value.endsWith("inf")) return value;
  if (unit === "dB" || unit === "IoU") return show({ unit }, value);
  return number(num(value));
}

function evaluatedTable({ key, title, note: text, columns, rows }) {
  const cells = columns.map((column, i) => [
    h("span", { title: column.doc }, column.label + (["", "dB", "IoU"].includes(column.unit) ? "" : ", " + column.unit)),
    (row) => evaluationCell(column, row), i === 0 ? "wrap" : ""]);
  return section(key, title, h("div", { class: "card scroll" }, table(cells, rows), note(text)));
}

function evaluatedPictures(data) {
  if (data.pictures.length === 0) return null;
  return section("pictures", "Pictures", data.pictures.map((view) => {
    const row = h("div", { class: "row" });
    view.pictures.forEach(({ caption, source }) => picture(row, caption, `${caption}, ${view.title}`, source));
    return h("article", { class: "card view" }, h("div", { class: "head" }, h("h3", {}, view.title),
      h("span", { class: "tag val" }, view.tag)), row);
  }));
}

function drawEvaluation(data) {
  const { evaluation } = data;
  const sections = [...data.tables.map(evaluatedTable), evaluatedPictures(data),
    listSection("notes", "Notes", evaluation.notes)].filter((one) => one);
  document.title = "pathfit evaluation";
  document.querySelector("main").append(
    h("header", {}, h("h1", {}, "Evaluation"), h("p", { class: "sub" },
      evaluation.run + (evaluation.truth ? " against " + evaluation.truth : ""))),
    h("nav", { "aria-label": "Sections" }, sections.map((one) => h("a", { href: "#" + one.id }, one.title))),
    ...sections.map((one) => one.node));
}

// ---- the start of a fit over its photos (app/output/check_page.cpp)

/** What is drawn over photos: its class, what it is called, whether it is shown at first. */
const OVER = [["outline", "outline of the start"], ["mask", "outline of the mask"], ["axes", "axes x, y, z"], ["light", "lights"]];

/** A photo with drawings in pixels of the check; lines keep their width at any size. */
function checkedPhoto(view) {
  const [width, height] = view.size;
  const line = ([a, b], css) => s("path", { class: css, d: `M${a[0]} ${a[1]}L${b[0]} ${b[1]}` });
  const inside = ([x, y]) => x >= 0 && y >= 0 && x <= width && y <= height;
  const size = Math.max(width, height);
  const axes = view.axes.map((ends, i) => (ends ? [line(ends, "axis" + i),
    s("text", { class: "axis" + i, x: ends[1][0], y: ends[1][1] }, "xyz"[i])] : []));
  const lights = view.lights.map(({ name, at, arrow }) => [
    arrow ? [line(arrow, "ray"), s("text", { class: "ray", x: arrow[1][0], y: arrow[1][1] }, name)] : [],
    at && inside(at) ? s("circle", { class: "lamp", cx: at[0], cy: at[1], r: size / 60 }) : []]);
  const path = (css, d) => (d ? s("path", { class: css, d }) : []);
  const drawing = s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "start over " + view.name, tabindex: 0 },
    s("image", { href: view.pictures.photo, width, height }),
    s("g", { class: "over-mask" }, path("mask", view.mask)), s("g", { class: "over-outline" }, path("outline", view.outline)),
    s("g", { class: "over-light" }, lights), s("g", { class: "over-axes" }, axes));
  const figure = h("figure", { class: "checked", id: "view" + view.index }, drawing, h("figcaption", {}, h("b", {}, view.name),
    view.validation ? [" ", h("span", { class: "tag val" }, "held out")] : "",
    ` IoU ${fixed(num(view.iou), 3)}, start covers ${fixed(100 * view.covered, 1)} %`));
  const words = [...axes, ...lights].flat(Infinity).filter((node) => node.tagName === "text");
  const letter = (share) => words.forEach((node) => { node.style.fontSize = share * size + "px"; });
  const enlarge = () => letter(figure.classList.toggle("large") ? 0.022 : 0.05);
  letter(0.05);
  drawing.addEventListener("click", enlarge);
  drawing.addEventListener("keydown", (event) => event.key === "Enter" && enlarge());
  return figure;
}

function checkedViewsSection(data) {
  const grid = h("div", { class: "grid" }, data.views.map(checkedPhoto));
  const boxes = OVER.map(([key, words]) => {
    const box = h("input", { type: "checkbox", checked: "" });
    box.addEventListener("change", () => grid.classList.toggle("no-" + key, !box.checked));
    return h("label", { class: "key over-" + key }, box, " ", words);
  });
  return section("views", "The start over every photo", h("div", { class: "card" }, h("div", { class: "tools" }, boxes), grid,
    note("Where cameras and mesh are right, the outline of the start lies about that of the mask, or of the object in the photo. " +
      "Axes are the world's (x red, y green, z blue) from the middle of all meshes; arrows from there point to lights, dots are " +
      "where they are. Click at a photo to enlarge it.")));
}

function checkedStagesSection({ check }) {
  if (check.stages.length === 0) return null;
  const columns = [["Stage", (stage) => stage.name], ["Unknown numbers", (stage) => stage.unknowns],
    ["Photos at", (stage) => fixed(100 * stage.image_scale, 1, "%")], ["Rounds, at most", (stage) => stage.max_rounds],
    ["Memory", (stage) => bytes(num(stage.memory_bytes))], ["Solved by", (stage) => stage.linear_solver ?? "–"],
    ["First round", (stage) => duration(num(stage.first_round_s))], ["Likely", (stage) => duration(num(stage.likely_s))],
    ["All rounds", (stage) => duration(num(stage.most_s))]];
  return section("stages", "Memory and time", h("div", { class: "card scroll" }, table(columns, check.stages),
    note("Measured on a few photos of the start, on this machine as busy as it was. A stage ends where nothing more is to be " +
      "gained, which only the fit can tell: likely is what that usually takes.")));
}

function checkedLightsSection(data) {
  if (data.lights.length === 0) return null;
  const columns = [["Light", (light) => light.name], ["Kind", (light) => light.kind, "left"],
    ["Attached to the", (light) => light.frame, "left"], ["Where, in that frame", (light) => light.place, "left"],
    ["Shines in", (light) => `${light.photos} of ${data.views.length} photos`]];
  return section("lights", "Lights", h("div", { class: "card scroll" }, table(columns, data.lights)));
}

function checkedUnknownsSection(data) {
  if (data.parameters.length === 0) return null;
  const bound = (p) => ([p.lower_bound, p.upper_bound].some((one) => Number.isFinite(num(one)))
    ? `[${number(num(p.lower_bound))}, ${number(num(p.upper_bound))}]` : "none");
  const columns = [["Name", (p) => p.name], ["Unit", (p) => p.unit], ["Numbers", (p) => p.num_scalars],
    ["Start", (p) => (p.num_scalars > 1 ? `${number(num(p.minimum))} … ${number(num(p.maximum))}` : number(num(p.initial)))],
    ["Bounds", bound], ["", (p) => (p.held ? h("span", { class: "tag" }, "held") : "")]];
  return section("unknowns", "Unknowns", h("div", { class: "card scroll" }, table(columns, data.parameters)));
}

function drawCheck(data) {
  const { check } = data;
  const memory = check.stages.map((stage) => num(stage.memory_bytes)).filter(Number.isFinite);
  const total = (key) => {
    const known = check.stages.map((stage) => num(stage[key])).filter(Number.isFinite);
    return duration(known.length > 0 ? known.reduce((a, b) => a + b, 0) : NaN);
  };
  const known = data.views.map((view) => num(view.iou)).filter(Number.isFinite).sort((a, b) => a - b);
  const vertices = check.meshes.reduce((sum, mesh) => sum + mesh.vertices, 0);
  const good = check.warnings.length === 0;
  const model = modelSection(data);
  const config = section("config", "Config", h("div", { class: "card" },
    h("details", {}, h("summary", {}, data.config_path), h("pre", {}, data.config))));
  const sections = [checkedViewsSection(data), model, checkedStagesSection(data), checkedUnknownsSection(data),
    checkedLightsSection(data), listSection("assumptions", "Assumptions", check.assumptions),
    listSection("attribution", "Attribution", data.attributions), config].filter((one) => one);
  document.title = data.name + " – pathfit check";
  document.querySelector("main").append(
    h("header", {}, h("h1", {}, data.name), h("p", { class: "sub" }, `${data.config_path} · what a fit would begin with`)),
    h("section", { class: "card verdict " + (good ? "finished" : "stopped") },
      h("span", { class: "badge" }, good ? "no objection" : check.warnings.length === 1 ? "1 warning" : check.warnings.length + " warnings"),
      h("div", { class: "tiles" },
        tile("Photos", String(data.views.length), `${data.views.filter((view) => view.validation).length} held out`),
        tile("Start and masks, IoU", fixed(known.length > 0 ? known[known.length >> 1] : NaN, 3),
          known.length > 0 ? `median; worst ${fixed(known[0], 3)}` : "no silhouettes"),
        tile("Start", String(vertices), `vertices of ${check.meshes.length} ${check.meshes.length === 1 ? "mesh" : "meshes"}`),
        tile("Memory", bytes(memory.length > 0 ? Math.max(...memory) : NaN), "at its peak"),
        tile("Time", total("likely_s"), "likely; at most " + total("most_s"))),
      good ? null : h("ul", { class: "warnings" }, check.warnings.map((warning) => h("li", {}, warning)))),
    h("nav", { "aria-label": "Sections" }, sections.map((one) => h("a", { href: "#" + one.id }, one.title))),
    ...sections.map((one) => one.node));
  model?.start?.();
}

const shown = JSON.parse(document.getElementById("data").textContent);
if (shown.check) drawCheck(shown);
else if (shown.runs) drawComparison(shown);
else if (shown.evaluation) drawEvaluation(shown);
else draw(shown);
