// The live page: it holds the samples, and draws what the view asks for.

import { Drive } from "./drive.js";
import { Link } from "./link.js";
import { Readout, number } from "./readout.js";
import { Store } from "./store.js";
import { Strips, label } from "./strips.js";
import { SINGLE, Trigger } from "./trigger.js";

const SPANS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120];
const NOISE = 0.02; // of what a channel spans in the view: a smaller step is no edge
const FIGURES_MS = 500;
const by = (id) => document.getElementById(id);

const view = { span: 2, held: null, cursors: { A: null, B: null }, placing: "A" };
const counts = { frames: 0, lost: 0, draws: 0, rate: 0 };
const trigger = new Trigger();
const readout = new Readout(by("readout"));
let store = null, strips = null, changed = true, said = {}, linked = false;

const link = new Link({ status, frame, refused, open: () => { linked = true; show(); }, closed });
const drive = new Drive(by("drive"), link);

function status(news) {
  said = news;
  by("title").textContent = `motorid ${news.command}: ${news.rig}${news.serial ? `, ${news.serial}` : ""}`;
  document.title = by("title").textContent;
  drive.status(news);
  const names = (channels) => (channels ?? []).map((one) => one.name + one.unit).join();
  if (news.channels && names(news.channels) !== names(store?.channels)) begin(news.channels);
  show();
}

function begin(channels) {
  strips?.destroy();
  store = new Store(channels);
  strips = new Strips(by("plots"), channels, { zoom, click, wheel, follow });
  strips.marks = marks;
  readout.name(channels);
  by("source").replaceChildren(...channels.map((one, c) => new Option(label(one), c)));
  trigger.channel = 0;
  trigger.arm(store);
}

function frame({ lost, run, start, period, columns }) {
  if (!store || columns.length !== store.channels.length || !columns[0].length) return;
  counts.frames++;
  counts.lost += lost;
  store.append(run, start, period, columns);
  changed = true;
}

function refused(why) {
  drive.rest();
  by("said").textContent = why;
}

function closed() {
  if (linked) drive.rest();
  linked = false;
  show();
}

function show() {
  const state = linked ? said.state ?? "connecting" : "gone";
  by("state").textContent = state;
  by("state").className = `pill ${state}`;
  by("said").textContent = linked ? said.text ?? "" : "The program has ended, or cannot be reached. What was seen stays here.";
}

// ---- the view

function range() {
  if (view.held) return view.held;
  const stood = trigger.view(store, view.span);
  if (stood) return stood;
  return [store.newest - view.span, store.newest];
}

function hold(from, to) {
  view.held = [from, Math.max(to, from + 1e-4)];
  by("pause").setAttribute("aria-pressed", "true");
  changed = true;
}

function follow() {
  view.held = null;
  by("pause").setAttribute("aria-pressed", "false");
  if (store) trigger.arm(store);
  changed = true;
}

function zoom(from, to) { hold(from, to); }

function wheel(time, factor) {
  const [from, to] = range();
  hold(time - (time - from) * factor, time + (to - time) * factor);
}

function scaled(factor) {
  if (!store) return;
  const [from, to] = range();
  if (view.held) { wheel((from + to) / 2, factor); return; }
  const at = SPANS.findIndex((one) => one >= view.span * 0.999) + (factor > 1 ? 1 : -1);
  view.span = SPANS[Math.min(Math.max(at, 0), SPANS.length - 1)];
  by("span").value = view.span;
  changed = true;
}

function moved(share) {
  if (!store) return;
  const [from, to] = range();
  hold(from + share * (to - from), to + share * (to - from));
}

function pause() {
  if (view.held) follow(); else if (store) hold(...range());
}

// ---- cursors and trigger

function click(time, other) {
  const name = other ? "B" : view.placing;
  view.cursors[name] = time;
  if (name === "A" && !other) place("B");
  changed = true;
}

function place(name) {
  view.placing = name;
  for (const one of ["A", "B"]) by(one).setAttribute("aria-pressed", String(one === name));
}

function clear() {
  view.cursors = { A: null, B: null };
  place("A");
  changed = true;
}

function marks() {
  const found = [];
  for (const name of ["A", "B"]) {
    const time = view.cursors[name];
    if (time !== null) found.push({ time, text: name, colour: `--c-${name.toLowerCase()}` });
  }
  if (trigger.mode !== "off") {
    found.push({ level: trigger.level, channel: trigger.channel, colour: "--c-trigger", dashed: true });
    if (trigger.shown !== null) found.push({ time: trigger.shown, text: "T", colour: "--c-trigger", dashed: true });
  }
  return found;
}

function triggered() {
  trigger.mode = by("mode").value;
  trigger.channel = Number(by("source").value);
  trigger.rising = Boolean(by("edge").value);
  trigger.level = by("level").valueAsNumber || 0;
  follow();
}

function scan() {
  if (view.held || trigger.mode === "off") return;
  const seen = strips.ranges[trigger.channel];
  const before = trigger.shown;
  trigger.scan(store, view.span, seen ? NOISE * (seen[1] - seen[0]) : 0);
  if (trigger.mode === SINGLE && trigger.shown !== null && before === null) hold(...range());
}

// ---- drawing

function draw() {
  requestAnimationFrame(draw);
  if (!changed || !strips) return;
  changed = false;
  scan();
  const [from, to] = range();
  strips.draw(from, to, store.envelope(from, to, strips.width));
  counts.draws++;
}

let drawn = 0, since = performance.now();

function figures() {
  const now = performance.now();
  counts.rate = 1e3 * (counts.draws - drawn) / (now - since);
  [drawn, since] = [counts.draws, now];
  if (!store) return;
  readout.show(store, view.cursors, range());
  const parts = [`${counts.rate.toFixed(0)} frames/s`, `${(1 / store.period).toFixed(0)} Hz`,
    `${store.received.toLocaleString("en")} samples`, `${store.missing} missing`];
  if (counts.lost) parts.push(`${counts.lost} frames skipped by this page`);
  by("figures").textContent = parts.join(" · ");
}

// ---- hands

by("span").replaceChildren(...SPANS.map((one) => new Option(one < 1 ? `${1e3 * one} ms` : `${one} s`, one)));
by("span").value = view.span;
by("span").onchange = () => { view.span = Number(by("span").value); if (view.held) follow(); changed = true; };
by("pause").onclick = pause;
by("closer").onclick = () => scaled(0.5);
by("wider").onclick = () => scaled(2);
by("back").onclick = () => moved(-0.5);
by("forth").onclick = () => moved(0.5);
by("A").onclick = () => place("A");
by("B").onclick = () => place("B");
by("clear").onclick = clear;
by("arm").onclick = triggered;
for (const id of ["mode", "source", "edge", "level"]) by(id).onchange = triggered;
place("A");

const KEYS = {
  " ": pause, "+": () => scaled(0.5), "-": () => scaled(2), a: () => place("A"), b: () => place("B"),
  ArrowLeft: () => moved(-0.5), ArrowRight: () => moved(0.5), Escape: clear,
};
addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, button") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (KEYS[event.key]) { event.preventDefault(); KEYS[event.key](); }
});
const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => strips?.redraw());
setInterval(figures, FIGURES_MS);
requestAnimationFrame(draw);

// for who looks at the page from outside
globalThis.motorid = {
  get figures() {
    return { ...counts, received: store?.received ?? 0, missing: store?.missing ?? 0, newest: store?.newest ?? 0,
      view: store ? range() : null, held: view.held !== null, shown: trigger.shown, number };
  },
};
