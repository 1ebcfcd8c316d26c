"use strict";
// Sends what is turned, pressed and chosen to the session, and prints what it answers. While an answer is awaited
// the newest turn of a knob waits, those before it are dropped: a picture is never older than one simulation.

const at = (id) => document.getElementById(id);
const knobs = new Map();
const SETTLED_MS = 150, waiting = [], latencies = [];
const ARROWS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };
const pending = new Map(); // values asked for and not yet answered
let settling = 0, turned = false, asked = null;
let wire = null, number = 0, awaited = 0, grip = 0, began = 0, state = null;

function ask(message) {
  const last = waiting[waiting.length - 1];
  if (message.do === "turn" && last && last.do === "turn" && last.name === message.name) waiting.pop();
  waiting.push(message);
  next();
}

function next() {
  if (!wire || awaited || !waiting.length) return;
  const message = waiting.shift();
  asked = message;
  clearTimeout(settling);
  settling = 0;
  turned = message.do === "turn";
  awaited = ++number;
  began = message.began ?? 0;
  wire.asked = JSON.stringify({ ...message, number });
}

// A knob's place on its track and its value.
const ends = (row) => [Number(row.dataset.low), Number(row.dataset.high), row.dataset.log === "1"];
function valueAt(row, share) {
  const [low, high, log] = ends(row);
  return log ? low * (high / low) ** share : low + share * (high - low);
}

function turn(name, value) {
  const [low, high] = ends(knobs.get(name)), inside = Math.min(Math.max(value, low), high);
  pending.set(name, inside);
  ask({ do: "turn", name, value: inside, grip: `grip ${grip}`, began: performance.now() });
}

// With Shift a press of an arrow key, or a pixel of a drag, is a fine step.
const standing = (name) => pending.get(name) ?? state.knobs[name].value;

function pressedFine(event, name) {
  const steps = ARROWS[event.key];
  if (!event.shiftKey || !steps || !state) return;
  event.preventDefault();
  turn(name, standing(name) + steps * state.knobs[name].fine);
}

function draggedFine(event, name) {
  if (!event.shiftKey || event.button !== 0 || !state) return;
  event.preventDefault(); // the thumb does not jump to the pointer
  event.target.focus();
  const from = standing(name), fine = state.knobs[name].fine, at = event.clientX;
  const moved = (move) => turn(name, from + (move.clientX - at) * fine);
  document.addEventListener("mousemove", moved);
  document.addEventListener("mouseup", () => document.removeEventListener("mousemove", moved), { once: true });
}

function joined(name, row) {
  const range = row.querySelector("[type=range]"), written = row.querySelector("[type=number]");
  range.addEventListener("pointerdown", () => { grip += 1; });
  range.addEventListener("mousedown", (event) => draggedFine(event, name));
  range.addEventListener("keydown", (event) => { if (!event.repeat) grip += 1; pressedFine(event, name); });
  range.addEventListener("input", () => turn(name, valueAt(row, range.value / range.max)));
  for (const input of [range, written]) {
    input.addEventListener("focus", () => { if (state && state.hand !== name) ask({ do: "take", name }); });
  }
  written.addEventListener("change", () => {
    if (!Number.isFinite(written.valueAsNumber)) { written.value = state.knobs[name].text; return; }
    row.dataset.written = "1"; // what is used goes back into the box, where it is another value
    ask({ do: "turn", name, value: written.valueAsNumber });
  });
  row.querySelector("[type=checkbox]").addEventListener("change", (event) => {
    ask({ do: "free", name, is: event.target.checked });
  });
}

// A fit that adds terms to the mechanism brings rows of its own.
function joinedAll() {
  knobs.clear();
  for (const row of document.querySelectorAll(".knob")) knobs.set(row.dataset.name, row);
  for (const [name, row] of knobs) joined(name, row);
}
joinedAll();

const effects = new Map([...document.querySelectorAll(".effect-named")].map((row) => [row.dataset.effect, row]));
for (const [name, row] of effects) {
  row.querySelector("input")?.addEventListener("change", (event) => ask({ do: "switch", name, is: event.target.checked }));
}

for (const id of ["undo", "estimate", "file", "save", "fit", "search", "cancel"]) {
  at(id).addEventListener("click", () => ask({ do: id }));
}
at("compare").addEventListener("change", (event) => ask({ do: "compare", is: event.target.checked }));
document.addEventListener("keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "z" && event.target.type !== "number") {
    event.preventDefault();
    ask({ do: "undo" });
  }
});

const chips = [...document.querySelectorAll(".chip")];
const look = (records) => ask({ do: "look", records, seconds: Number(at("seconds").value) });
for (const chip of chips) {
  chip.addEventListener("click", () => {
    const now = state.records.map((r) => r.name), name = chip.dataset.record;
    const records = now.includes(name) ? now.filter((other) => other !== name) : [...now, name];
    if (records.length) look(records);
  });
}
at("seconds").addEventListener("change", () => look(state.records.map((r) => r.name)));

// What the session says.
function element(kind, text, name) {
  const made = document.createElement(kind);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

function marked(row, kind, place) {
  const mark = row.querySelector(`.mark.${kind}`);
  mark.hidden = place === null || place === undefined;
  // the thumb's middle runs from half its width to the track's width less that
  if (!mark.hidden) mark.style.left = `calc(8px + ${place} * (100% - 16px))`;
}

// What has not changed is not written: each writing makes the browser work out styles anew.
function set(target, name, value) {
  if (target[name] !== value) target[name] = value;
}

function printedKnob(row, now, before) {
  const range = row.querySelector("[type=range]"), written = row.querySelector("[type=number]");
  const name = row.dataset.name;
  const turning = waiting.some((m) => m.name === name) || (awaited && state.answered !== awaited && asked.name === name);
  if (!turning) {
    pending.delete(name);
    set(range, "value", String(Math.round(now.place * range.max)));
  }
  if (row.dataset.written && !turning) {
    delete row.dataset.written;
    written.value = now.text;
  }
  if (before && JSON.stringify(now) === JSON.stringify(before)) return;
  range.setAttribute("aria-valuetext", now.text);
  if (document.activeElement !== written) set(written, "value", now.text);
  set(row.querySelector("[type=checkbox]"), "checked", now.free);
  set(row.querySelector(".away"), "textContent", now.away);
  set(row.querySelector(".mark.estimate"), "title", now.estimate);
  marked(row, "estimate", now.estimate_place);
}

function printedLimit(row, words) {
  const said = row.querySelector(".limit");
  set(said, "hidden", !words);
  set(said, "textContent", words ?? "");
  row.classList.toggle("limited", Boolean(words));
}

function printedEffect(row, isOn) {
  const input = row.querySelector("input");
  if (input) set(input, "checked", isOn);
  row.classList.toggle("off", !isOn);
}

function printedPanel(panel, record) {
  set(panel, "hidden", !record);
  if (!record) return;
  set(panel, "className", `panel ${record.grade}`);
  Object.assign(panel.dataset, { record: record.name, ratio: record.ratio });
  set(panel.querySelector("h2"), "textContent", record.name);
  set(panel.querySelector(".state"), "textContent", record.words);
  set(panel.querySelector(".effect"), "textContent", record.effect);
  const numbers = panel.querySelector(".numbers");
  if (!numbers.children.length) numbers.append(...record.numbers.map(() => document.createElement("li")));
  record.numbers.forEach(([label, value], k) => {
    const line = numbers.children[k];
    if (!line.children.length) line.append(element("span", `${label} `), element("b", ""));
    set(line.lastChild, "textContent", value);
  });
}

function printedSweep(section, sweep) {
  set(section, "hidden", !sweep);
  if (!sweep) return;
  set(section.querySelector("h2"), "textContent", `${sweep.name}, over time and frequency`);
  set(section.querySelector(".words"), "textContent", `${sweep.words} Drawn anew when the slider rests.`);
  const tops = section.querySelector(".tops"), words = sweep.tops_hz.length < 2 ? [] : sweep.tops_hz.map((hz) => `up to ${hz} Hz`);
  if (tops.dataset.words === String(words)) return;
  tops.dataset.words = words;
  tops.replaceChildren(...words.map((text, k) => {
    const button = element("button", text, "chip");
    button.type = "button";
    button.addEventListener("click", () => {
      wire.document.get_model_by_name(`frequency_${section.dataset.sweep}`).setv({ start: 0, end: sweep.tops_hz[k] });
    });
    return button;
  }));
}

function printedVerdict(verdict, source) {
  at("verdict").className = `verdict ${verdict ? verdict.tone : ""}`;
  at("said").hidden = !verdict;
  at("headline").textContent = verdict ? verdict.headline : "No estimate yet.";
  at("source").textContent = verdict ? `Said of the last estimate, ${source}.` : "“Search from scratch” makes one from the catalogue, as mechid identify does; “Fit from here” makes one from the values below, once they are near.";
  at("answers").replaceChildren(...(verdict ? verdict.questions : []).map(({ question, answers }) => {
    const part = element("div", ""), list = element("ul", "");
    list.append(...answers.map((answer) => element("li", answer)));
    part.append(element("h3", question), list);
    return part;
  }));
}

function printedRun(run) {
  const running = run !== null && run.state === "running";
  for (const id of ["fit", "search"]) at(id).disabled = running;
  at("cancel").hidden = !running || run.elsewhere;
  at("course").hidden = !run;
  at("run-words").className = run ? run.state : "";
  at("run-words").textContent = run ? run.words : "";
  at("run-line").textContent = run ? [run.stage, run.line, run.cost, run.noise, run.elapsed].filter(Boolean).join(", ") : "";
  if (running && !at("course").dataset.opened) { at("course").open = true; at("course").dataset.opened = "1"; }
  if (!running) delete at("course").dataset.opened;
  for (const [name, row] of knobs) marked(row, "run", running ? run.places[name] : null);
}

// The session that this tab has goes on when the page is loaded anew: it is asked for by its token.
function remembered() {
  if (state.answered) sessionStorage.setItem("mechid tab", state.tab);
}

function printed() {
  const before = state;
  state = JSON.parse(wire.page_state);
  remembered();
  if (state.groups) { at("groups").innerHTML = state.groups; pending.clear(); joinedAll(); }
  for (const [name, now] of Object.entries(state.knobs)) printedKnob(knobs.get(name), now, before?.knobs[name]);
  for (const [name, row] of knobs) printedLimit(row, state.limited[name]);
  for (const [name, isOn] of Object.entries(state.effects)) printedEffect(effects.get(name), isOn);
  for (const [name, row] of knobs) row.classList.toggle("held", name === state.hand);
  document.querySelectorAll(".panel").forEach((panel, k) => printedPanel(panel, state.records[k]));
  document.querySelectorAll(".sweep").forEach((section, k) => printedSweep(section, state.sweeps[k]));
  for (const chip of chips) {
    chip.setAttribute("aria-pressed", state.records.some((r) => r.name === chip.dataset.record));
    set(chip.querySelector(".use"), "textContent", state.uses[chip.dataset.record]);
  }
  at("seconds").value = [...at("seconds").options].find((o) => Number(o.value) === state.seconds)?.value ?? "1000000000.0";
  set(at("undo"), "disabled", !state.can_undo);
  for (const id of ["estimate", "compare"]) set(at(id), "disabled", !state.reaches_estimate);
  set(at("compare"), "checked", state.compares);
  at("panels").classList.toggle("comparing", state.compares);
  for (const id of ["fit", "search"]) at(id).classList.toggle("strong", id === state.primary);
  set(at("free-count"), "textContent", `${state.free} parameters free`);
  set(at("note"), "textContent", state.note);
  set(at("note"), "hidden", !state.note);
  set(at("hand-name"), "textContent", state.hand);
  set(at("hand-fine"), "textContent", state.knobs[state.hand].fine_text);
  set(at("hand-hover"), "textContent", knobs.get(state.hand).querySelector(".name").title);
  if (state.equations) at("equations").innerHTML = state.equations.map(([l, r]) => `<p><math><mrow>${l}<mo>=</mo>${r}</mrow></math></p>`).join("");
  if (JSON.stringify([state.verdict, state.estimate]) !== JSON.stringify([before?.verdict, before?.estimate]) || !before) {
    printedVerdict(state.verdict, state.estimate);
  }
  at("verdict").classList.toggle("stale", Boolean(state.apart));
  set(at("apart"), "textContent", state.apart);
  set(at("apart"), "hidden", !state.apart);
  if (JSON.stringify(state.run) !== JSON.stringify(before?.run)) printedRun(state.run);
  if (state.file) saved(state.file);
  if (state.answered === awaited && awaited) {
    awaited = 0;
    next();
    if (!awaited && turned) settling = setTimeout(() => { settling = 0; ask({ do: "settle" }); }, SETTLED_MS);
  }
}

// From the turn of a slider to the end of the frame in which its curves are drawn, ms.
function drawnSoon() {
  const since = began;
  began = 0;
  if (since) requestAnimationFrame(() => setTimeout(() => latencies.push(performance.now() - since)));
}

function saved(text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
  link.download = "mechanism.toml";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// At each drawing Bokeh writes a dozen style sheets a figure anew, mostly as they were, and the browser works out all
// styles again; a sheet that stays as it is is not written.
function sheetsLeftAlone() {
  const sheet = Bokeh.require("core/dom").InlineStyleSheet.prototype, write = sheet._update;
  sheet._update = function (css) { if (this.css !== css) write.call(this, css); };
}

function repainted() {
  for (const root of wire.document.roots()) painted(root);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (wire) repainted(); });
at("theme").addEventListener("click", () => {
  const dark = getComputedStyle(document.documentElement).getPropertyValue("--scheme").trim() === "dark";
  document.documentElement.dataset.theme = dark ? "light" : "dark";
  if (wire) repainted();
});

(function connected() {
  const shown = window.Bokeh && Bokeh.documents[0];
  const found = shown && shown.get_model_by_name("wire");
  if (!found) { setTimeout(connected, 20); return; }
  wire = found;
  sheetsLeftAlone();
  repainted();
  if (matchMedia("(pointer: coarse)").matches) {
    for (const root of shown.roots()) for (const model of root.references()) {
      if (model.type === "Toolbar") model.setv({ active_drag: null }, { sync: false });
    }
  }
  wire.properties.page_state.change.connect(printed);
  for (const root of shown.roots().filter((r) => r.name.startsWith("spectrum"))) {
    const { data_source } = [...root.references()].find((m) => m.type === "GlyphRenderer" && m.name.endsWith("spectrum"));
    data_source.properties.data.change.connect(drawnSoon);
  }
  shown.on_event("connection_lost", () => { at("gone").hidden = false; });
  if (wire.page_state) printed();
  ask({ do: "hello", tab: sessionStorage.getItem("mechid tab") ?? "" });
})();
window.mechid = { latencies, knobs, valueAt, ask, state: () => state, idle: () => Boolean(wire) && !awaited && !waiting.length && !settling };
