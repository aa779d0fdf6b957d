// The operator's page: what the station shows, large, with the run as it goes on.

import { Keys } from "./keys.js";
import { Link } from "./link.js";
import { number } from "./readout.js";
import { Sound } from "./sound.js";
import { Store } from "./store.js";
import { Strips } from "./strips.js";
import { WORDS, preferred, translated } from "./words.js";

const MARKS = { READY: "●", RUN: "↻", PASS: "✓", FAIL: "✗", INVALID: "!", gone: "⚡", "": "…" };
const SHOWN = ["current", "speed"];
const CAPACITY = 1 << 17; // samples kept: a run or two
const by = (id) => document.getElementById(id);

let language = preferred(), said = {}, linked = false, changed = false;
let store = null, strips = null, picked = [], run = 0, begun = 0;
const text = () => WORDS[language];
const sound = new Sound(by("sound"), text);
const link = new Link({ status, frame, refused, open: () => { linked = true; show(); }, closed });
const keys = new Keys({
  form: by("scan"), input: by("number"), pad: by("pad"), keypad: by("keypad"),
  send: (serial) => { by("refused").textContent = ""; link.ask({ ask: "scan", serial }); },
});

function status(news) {
  const fresh = said.word !== undefined && judged(news) !== judged(said);
  said = news;
  if (fresh) {
    by("refused").textContent = "";
    sound.play(news.word);
  }
  const found = (news.channels ?? []).map((one) => one.name).join();
  if (news.channels && found !== store?.channels.map((one) => one.name).join()) begin(news.channels);
  show();
}

// Changes with each motor that is judged.
function judged({ word, counts }) {
  return `${word} ${Object.values(counts ?? {}).join()}`;
}

function begin(channels) {
  store = new Store(channels, CAPACITY);
  picked = channels.map((one, c) => [one, c]).filter(([one]) => SHOWN.includes(one.name));
  plots();
}

function plots() {
  const none = () => {}, hands = { zoom: none, click: none, wheel: none, follow: none };
  strips?.destroy();
  strips = new Strips(by("plots"), picked.map(([one]) => ({ ...one, label: text()[one.name] })), hands);
  changed = true;
}

function frame(one) {
  if (!store || one.columns.length !== store.channels.length || !one.columns[0].length) return;
  if (one.run !== run) [run, begun] = [one.run, one.start];
  store.append(one.run, one.start, one.period, one.columns);
  changed = true;
}

function refused(why) { by("refused").textContent = translated(why, language); }

function closed() {
  linked = false;
  show();
}

// ---- what is said

function show() {
  const word = linked ? said.word ?? "" : "gone";
  document.body.dataset.word = word;
  document.documentElement.lang = language;
  by("mark").textContent = MARKS[word] ?? "";
  by("word").textContent = text()[word] ?? word;
  by("title").textContent = said.product ?? "motorid";
  document.title = `${text()[word] ?? word} · ${said.product ?? "motorid"}`;
  by("bench").textContent = [said.station, said.rig].filter(Boolean).join(" · ");
  by("serial").textContent = said.serial ?? "";
  by("next").textContent = linked ? translated(said.next ?? "", language) : text().goneNext;
  by("reasons").replaceChildren(...(linked ? said.lines ?? [] : []).map((line) => {
    const item = document.createElement("li");
    item.textContent = translated(line, language);
    return item;
  }));
  by("scan").hidden = !(linked && said.scans);
  if (by("scan").hidden) by("keypad").hidden = true;
  for (const one of document.querySelectorAll("[data-text]")) one.textContent = text()[one.dataset.text];
  by("language").textContent = text().other;
  by("language").lang = language === "en" ? "de" : "en";
  sound.show();
  shift();
  last();
}

function shift() {
  if (!said.counts) return;
  const { counts, golden } = said, good = said.first_pass_yield;
  const rows = [
    [text().counts, ["PASS", "FAIL", "INVALID"].map((one) => `${text()[one]} ${counts[one]}`).join("   ")],
    [text().yield, good === null ? "–" : `${number(100 * good)} % ${text().of(said.first_tests)}`],
  ];
  if (said.again) rows.push([text().again, said.again]);
  if (said.ignored) rows.push([text().ignored, said.ignored]);
  const due = said.golden_due === 0;
  const which = golden.length ? `${text().golden} ${golden.join(", ")}` : text().anyGood;
  rows.push([which, due ? text().due : text().dueIn(said.golden_due), due]);
  by("shift").replaceChildren(...rows.flatMap(([name, value, alarm]) => {
    const [term, told] = [document.createElement("dt"), document.createElement("dd")];
    term.textContent = name;
    told.textContent = value;
    told.classList.toggle("due", Boolean(alarm));
    return [term, told];
  }));
}

function last() {
  by("last").tBodies[0].replaceChildren(...(said.last ?? []).map((one) => {
    const row = document.createElement("tr");
    const time = one.time ? new Date(one.time) : null;
    const clock = time && !Number.isNaN(time.valueOf()) ? time.toLocaleTimeString(language, { hour12: false }) : "";
    for (const value of [one.serial, text()[one.outcome] ?? one.outcome, clock]) row.insertCell().textContent = value;
    row.cells[1].className = one.outcome;
    return row;
  }));
}

// ---- the run

function draw() {
  requestAnimationFrame(draw);
  if (!changed || !store?.end || !picked.length) return;
  changed = false;
  const { xs, ys } = store.envelope(begun, store.newest, strips.width);
  const points = { xs: xs.map((one) => one - begun), ys: picked.map(([, c]) => ys[c]) };
  strips.draw(0, Math.max(store.newest - begun, 0.1), points);
  by("now").replaceChildren(...picked.map(([one, c]) => {
    const told = document.createElement("span");
    told.textContent = `${text()[one.name]} ${number(store.value(c, store.end - 1))} ${one.unit}`;
    return told;
  }));
}

by("language").onclick = () => {
  language = language === "en" ? "de" : "en";
  localStorage.setItem("motorid language", language);
  show();
  if (store) plots();
};
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => strips?.redraw());
requestAnimationFrame(draw);
show();

// for who looks at the page from outside
globalThis.motorid = {
  get figures() { return { received: store?.received ?? 0, missing: store?.missing ?? 0, played: sound.played, keys: keys.form.hidden }; },
};
