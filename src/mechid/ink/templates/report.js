"use strict";
// Unpacks the records, draws a figure when it comes into view, and fills it anew with each zoom:
// the least and the largest sample of every column of the picture, or every sample where there is room.
// The Python twins are mechid.reports.packing, mechid.reports.trace, mechid.reports.outline and mechid.signal.envelope.

const text = (id) => document.getElementById(id).textContent;
const kinds = JSON.parse(text("figure-kinds"));
const records = new Map(JSON.parse(text("record-curves")).map((record) => [record.name, record]));
const documents = new Map();
const WIDTH = 900, ROOM_A_SAMPLE = 8;

async function inflated(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function unpacked({ kind, size, data }) {
  const planes = await inflated(data), words = new Uint32Array(size);
  for (let i = 0; i < size; i++) {
    words[i] = planes[i] | (planes[size + i] << 8) | (planes[2 * size + i] << 16) | (planes[3 * size + i] << 24);
  }
  return kind === "float" ? new Float32Array(words.buffer) : Int32Array.from(words, (z) => (z >>> 1) ^ -(z & 1));
}

const largest = (y, from) => y.reduce((a, b) => (b > a ? b : a), from); // skips what is no number
const smallest = (y, from) => y.reduce((a, b) => (b < a ? b : a), from);

function once(make) {
  let made = null;
  return () => (made ??= make());
}

const library = once(async () => {
  const script = document.createElement("script");
  script.src = URL.createObjectURL(new Blob([await inflated(text("bokeh-library"))], { type: "text/javascript" }));
  await new Promise((done, failed) => { script.onload = done; script.onerror = failed; document.head.append(script); });
  Bokeh.set_log_level("error");
});

async function allSamples({ model, difference, samples, step }) {
  const [second, apart] = await Promise.all([unpacked(model), unpacked(difference)]);
  const measured = new Float64Array(samples), modelled = new Float64Array(second.length);
  let rise = 0, level = 0;
  for (let i = 0; i < samples; i++) {
    if (i < second.length) {
      rise += second[i];
      level += rise;
      modelled[i] = level * step;
    }
    measured[i] = ((i < second.length ? level : 0) + apart[i]) * step;
  }
  return { measured, modelled, residual: modelled.map((value, i) => measured[i] - value) };
}

const summed = (differences, step) => {
  let sum = 0;
  return Float64Array.from(differences, (each) => (sum += each) * step);
};

// The extremes of every column of a long record: numbers of samples, and their values.
async function outlined({ outline, step }) {
  const curves = {};
  for (const [name, { numbers, steps }] of Object.entries(outline)) {
    curves[name] = { at: summed(await unpacked(numbers), 1), y: summed(await unpacked(steps), step) };
  }
  return curves;
}

// A layer is a stretch of time whose samples the page has, each curve with the numbers of its samples, or all of them.
async function stretchOf(trace) {
  const { start_s, sample_rate_hz, samples } = trace;
  const all = trace.outline ? {} : await allSamples(trace), curves = trace.outline ? await outlined(trace) : {};
  for (const [name, y] of Object.entries(all)) curves[name] = { at: null, y };
  return { start_s, sample_rate_hz, end_s: start_s + (samples - 1) / sample_rate_hz, curves };
}

for (const record of records.values()) {
  record.samples = once(() => allSamples(record.trace));
  record.layers = once(() => Promise.all([record.trace, ...(record.trace.stretches || [])].map(stretchOf)));
}

// The first place in ascending numbers that is not below one.
function placeOf(numbers, number) {
  let from = 0, to = numbers.length;
  while (from < to) {
    const middle = (from + to) >> 1;
    if (numbers[middle] < number) from = middle + 1;
    else to = middle;
  }
  return from;
}

function envelope(y, from, to, columns) {
  const n = to - from, kept = [];
  if (n <= 4 * columns) {
    for (let i = from; i < to; i++) kept.push(i);
    return kept;
  }
  for (let c = 0; c < columns; c++) {
    const end = from + Math.floor(((c + 1) * n) / columns);
    let least = from + Math.floor((c * n) / columns), most = least;
    for (let i = least + 1; i < end; i++) {
      if (y[i] < y[least]) least = i;
      if (y[i] > y[most]) most = i;
    }
    kept.push(Math.min(least, most));
    if (least !== most) kept.push(Math.max(least, most));
  }
  return kept;
}

function refilled(shown) {
  const { model, layers, width } = shown, time = model("time"), margin = 0.02 * (time.end - time.start);
  const inside = layers.filter((one) => one.start_s <= time.start && time.end <= one.end_s);
  const { start_s, sample_rate_hz, curves } = inside[inside.length - 1] || layers[0];
  for (const [name, { at, y }] of Object.entries(curves)) {
    const first = Math.floor((time.start - margin - start_s) * sample_rate_hz);
    const last = Math.ceil((time.end + margin - start_s) * sample_rate_hz) + 1;
    const from = at ? Math.max(placeOf(at, first) - 1, 0) : Math.max(first, 0);
    const to = Math.min(at ? placeOf(at, last) + 1 : last, y.length);
    const kept = envelope(y, from, Math.max(to, from), width()), number = (i) => (at ? at[i] : i);
    model(`${name} data`).data = { x: kept.map((i) => start_s + number(i) / sample_rate_hz), y: kept.map((i) => y[i]) };
    const samples = model(`${name} samples`);
    if (samples) samples.visible = !at && kept.length > 0 && kept.length * ROOM_A_SAMPLE < width();
  }
}

function zoomed(shown, from, to) {
  shown.model("time").setv({ start: from, end: to });
}

const fill = {
  async torque(shown) {
    const { record, model } = shown, time = model("time");
    shown.layers = await record.layers();
    shown.width = () => Math.max(Math.round(shown.target.clientWidth || WIDTH), 100);
    const { from, to } = record.zooms[0];
    time.setv({ start: from, end: to, reset_start: from, reset_end: to });
    let asked = false;
    const again = () => {
      if (asked) return;
      asked = true;
      requestAnimationFrame(() => { asked = false; refilled(shown); });
    };
    time.properties.start.change.connect(again);
    time.properties.end.change.connect(again);
    refilled(shown);
  },
  async spectrum({ record, model }) {
    const hz = await unpacked(record.spectrum.hz);
    let most = 1e-12, floor = [];
    for (const name of ["residual", "measured", "modelled"]) {
      const y = await unpacked(record.spectrum[name]);
      model(`${name} data`).data = { x: hz, y };
      most = largest(y, most);
      if (name === "residual") floor = y.filter((value) => value > 0).sort();
    }
    const least = Math.max((floor[Math.floor(0.05 * floor.length)] || most * 1e-4) / 2, most * 1e-6), top = 4 * most;
    model("amplitude").setv({ start: least, end: top, reset_start: least, reset_end: top });
    model("frequency").setv({ start: 0, end: record.shown_hz, reset_start: 0, reset_end: record.shown_hz });
    const marks = (list) => ({ x: list.map((m) => m.hz), y: list.map(() => 0.9 * top), label: list.map((m) => m.label) });
    model("order marks").data = marks(record.orders);
    model("resonance marks").data = marks(record.orders.length ? [] : record.resonances);
  },
  async density({ record, model }) {
    const [x, y] = await Promise.all([unpacked(record.density.hz), unpacked(record.density.residual)]);
    model("residual data").data = { x, y };
    const level = record.noise_density, least = smallest(y, level || Infinity) / 3;
    const most = Math.max(3 * largest(y, level), 101 * least);
    if (least > 0 && most < Infinity) model("density").setv({ start: least, end: most, reset_start: least, reset_end: most });
    model("noise data").data = { x: [x[0], x[x.length - 1]], y: [record.noise_density, record.noise_density] };
  },
  async correlation({ record, model }) {
    const y = await unpacked(record.correlation);
    model("residual data").data = { x: Array.from(y, (_, i) => i + 1), y };
    model("limit").data = { y: [record.limit, -record.limit] };
  },
  async spectrogram({ record, model }) {
    const image = record.spectrogram, [from, to] = image.time_s, half = (0.5 * (to - from)) / (image.columns - 1);
    for (const which of ["measured", "modelled"]) {
      const levels = await unpacked(image[which]);
      const amplitude = Float32Array.from(levels, (level) => 10 ** (level / image.levels_a_decade));
      const { ndarray } = Bokeh.require("core/util/ndarray");
      const rows = ndarray(amplitude, { dtype: "float32", shape: [image.rows, image.columns] });
      const place = { x: [from - half], y: [0], dw: [to - from + 2 * half], dh: [image.hz] };
      model(`${which} image`).data = { image: [rows], ...place };
      const times = record.rate.map(([t]) => t);
      const orders = [0.5, 1, 2, 3, 4].map((order) => record.rate.map(([, rate]) => order * Math.abs(rate)));
      model(`${which} orders`).data = { x: orders.map(() => times), y: orders };
      model(`${which} resonances`).data = { y: record.resonances.map((m) => m.hz) };
    }
    model("colours").setv({ low: image.high / 3000, high: image.high });
    model("time").setv({ start: from, end: to, reset_start: from, reset_end: to });
    const top = Math.min(image.hz, 2.5 * Math.max(...record.rate.map(([, rate]) => Math.abs(rate))));
    model("frequency").setv({ start: 0, end: top, reset_start: 0, reset_end: top });
  },
};

// Figures are made for a torque in N m; of another quantity labels and tips have its own words and unit.
function renamed(root, record) {
  if (record.quantity === "torque") return;
  const tip = ([word, format]) => [word === "torque" ? record.quantity : word, format.replace("N m", record.unit)
    .replace(/^@y\{0\.0+\}/, "@y{0.0000e+0}")];
  for (const model of root.references()) {
    if (model.axis_label in record.labels) model.axis_label = record.labels[model.axis_label];
    if (model.title in record.labels) model.title = record.labels[model.title];
    if (model.type === "HoverTool") model.tooltips = model.tooltips.map(tip);
  }
}

async function drawn(target) {
  const { kind, record: name } = target.dataset, record = records.get(name);
  await library();
  const [view] = [...await Bokeh.embed.embed_item(kinds[kind], target)];
  const root = view.model, shown = { target, record, root, model: (id) => root.document.get_model_by_name(id) };
  painted(root);
  renamed(root, record);
  if (matchMedia("(pointer: coarse)").matches) {
    for (const model of root.references()) if (model.type === "Toolbar") model.active_drag = null;
  }
  await fill[kind](shown);
  documents.set(target, shown);
  target.classList.add("drawn");
}

const drawing = new Map();
function draw(target) {
  if (!drawing.has(target)) drawing.set(target, drawn(target));
  return drawing.get(target);
}

const near = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target); }
}, { rootMargin: "600px" });
document.querySelectorAll(".figure[data-kind]").forEach((target) => near.observe(target));

document.addEventListener("click", async (event) => {
  const button = event.target.closest("button[data-from]");
  if (!button) return;
  const target = document.getElementById(button.dataset.figure);
  await draw(target);
  zoomed(documents.get(target), Number(button.dataset.from), Number(button.dataset.to));
});

function repainted() {
  for (const { root } of documents.values()) painted(root);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repainted);
document.getElementById("theme").addEventListener("click", () => {
  const dark = getComputedStyle(document.documentElement).getPropertyValue("--scheme").trim() === "dark";
  document.documentElement.dataset.theme = dark ? "light" : "dark";
  repainted();
});
window.mechid = { records, documents, draw, envelope, zoomed };
