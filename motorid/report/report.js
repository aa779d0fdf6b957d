// Reading, zooming and saving of the plots. Without this script the page is whole.
"use strict";
(() => {
  const BOX = 1000;
  const LINES = ["measured", "fitted", "residual"];
  const MANY = 4; // lines: of more, the one under the pointer is read
  const FEWEST = 4; // box units: a shorter drag is a click

  class Scale {
    constructor(low, high) {
      this.whole = [low, high];
      this.reset();
    }
    reset() {
      [this.from, this.to] = [0, BOX]; // in box units, of the part that is shown
    }
    get isWhole() {
      return this.from === 0 && this.to === BOX;
    }
    value(at) {
      return this.whole[0] + (at / BOX) * (this.whole[1] - this.whole[0]);
    }
    ticks(count) {
      const [low, high] = [this.value(this.from), this.value(this.to)];
      const rough = (high - low) / count;
      const power = 10 ** Math.floor(Math.log10(rough));
      const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= 0.99 * rough);
      const places = Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 15);
      const out = [];
      for (let k = Math.ceil(low / step); k * step <= high; k += 1) {
        out.push([(k * step - low) / (high - low), (k * step).toFixed(places).replace("-", "−")]);
      }
      return out;
    }
  }

  class Plot {
    constructor(root) {
      const range = root.querySelector(".frame").dataset.range.split(" ").map(Number);
      this.root = root;
      this.frame = root.querySelector(".frame");
      this.svg = root.querySelector("svg");
      this.x = new Scale(range[0], range[1]);
      this.y = new Scale(range[3], range[2]); // the box runs downwards
      this.key = `${range[0]} ${range[1]}`;
      this.grid = root.querySelector(".grid");
      this.first = { grid: this.grid.getAttribute("d"), xs: this.side("xs"), ys: this.side("ys") };
    }
    side(name) {
      const found = this.root.querySelector(`.${name}`);
      return found && found.innerHTML;
    }
    get lines() {
      this.read ??= [...this.svg.querySelectorAll("path")]
        .map((path) => ({ path, name: nameOf(path) }))
        .filter((line) => line.name)
        .map((line) => ({ ...line, ...points(line.path) }));
      return this.read.filter((line) => line.x.length && getComputedStyle(line.path).display !== "none");
    }
    title(name) {
      const found = this.root.querySelector(`.${name}`);
      return found ? found.textContent : "";
    }
    show(from, to) {
      [this.x.from, this.x.to] = [from, to];
      let [least, most] = [Infinity, -Infinity];
      for (const line of this.lines) {
        line.x.forEach((x, k) => {
          if (x >= from && x <= to) {
            least = Math.min(least, line.y[k]);
            most = Math.max(most, line.y[k]);
          }
        });
      }
      if (!(most >= least)) [least, most] = [0, BOX];
      const room = 0.05 * (most - least) || 1;
      [this.y.from, this.y.to] = [least - room, most + room];
      this.draw();
    }
    reset() {
      this.x.reset();
      this.y.reset();
      this.draw();
    }
    draw() {
      const { x, y } = this;
      const [wide, high] = [x.to - x.from, y.to - y.from];
      this.svg.setAttribute("viewBox", `${x.from} ${y.from} ${wide} ${high}`);
      this.root.classList.toggle("zoomed", !x.isWhole);
      if (x.isWhole) {
        this.grid.setAttribute("d", this.first.grid);
        for (const name of ["xs", "ys"]) {
          if (this.first[name] !== null) this.root.querySelector(`.${name}`).innerHTML = this.first[name];
        }
        return;
      }
      const across = x.ticks(8);
      const up = new Scale(y.value(y.to), y.value(y.from)).ticks(5);
      const level = (share) => y.to - share * high;
      this.grid.setAttribute("d", [
        ...up.map(([s]) => `M${x.from} ${level(s)}h${wide}`),
        ...across.map(([s]) => `M${x.from + s * wide} ${y.from}v${high}`),
      ].join(""));
      this.labels("ys", "bottom", up);
      this.labels("xs", "left", across);
    }
    labels(name, side, ticks) {
      const place = this.root.querySelector(`.${name}`);
      if (!place) return;
      place.replaceChildren(...ticks.map(([share, text], k) => {
        const one = document.createElement("span");
        one.style[side] = `${100 * share}%`;
        one.className = k % 2 ? "odd" : "even";
        one.textContent = text;
        return one;
      }));
    }
    readout(at, level) {
      const x = this.x.from + at * (this.x.to - this.x.from);
      const y = this.y.from + level * (this.y.to - this.y.from);
      let read = this.lines.map((line) => ({ name: line.name, y: line.y[nearest(line.x, x)] }));
      if (read.length > MANY) {
        read.sort((one, other) => Math.abs(one.y - y) - Math.abs(other.y - y));
        read = read.slice(0, 1);
      }
      const said = read.map((line) => `${line.name} ${digits(this.y, line.y)}`);
      const unit = (title) => title.split(", ").at(-1);
      const group = groupOf(this).map((plot) => plot.title("xt")).find(Boolean) || "";
      const where = `${digits(this.x, x)} ${unit(group)}`;
      return `${where}: ${said.join("; ")} ${unit(this.title("yt"))}`;
    }
  }

  function nameOf(path) {
    return path.dataset.line || LINES.find((name) => path.classList.contains(name));
  }

  function points(path) {
    const [x, y] = [[], []];
    for (const found of path.getAttribute("d").matchAll(/[ML](-?[\d.]+) (-?[\d.]+)/g)) {
      x.push(Number(found[1]));
      y.push(Number(found[2]));
    }
    return { x, y };
  }

  function nearest(sorted, x) {
    let [low, high] = [0, sorted.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (sorted[middle] < x) low = middle;
      else high = middle;
    }
    return x - sorted[low] < sorted[high] - x ? low : high;
  }

  function digits(scale, at) {
    const span = Math.abs(scale.value(scale.to) - scale.value(scale.from));
    const places = Math.min(Math.max(0, 3 - Math.floor(Math.log10(span || 1))), 15);
    return scale.value(at).toFixed(places).replace("-", "−");
  }

  const plots = [...document.querySelectorAll(".plot")]
    .filter((root) => root.querySelector(".frame[data-range]"))
    .map((root) => new Plot(root));
  const groupOf = (plot) => {
    const run = plot.root.closest(".run") ?? plot.root.closest("figure");
    return plots.filter((other) => other.key === plot.key && run.contains(other.root));
  };

  function listen(plot) {
    const cursor = document.createElement("div");
    cursor.className = "cursor";
    const words = document.createElement("output");
    words.className = "readout";
    plot.frame.append(cursor, words);
    plot.frame.tabIndex = 0;
    let [begun, at, level] = [null, 0, 0.5];
    const share = (event) => {
      const box = plot.frame.getBoundingClientRect();
      level = (event.clientY - box.top) / box.height;
      return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
    };
    const mark = (to) => {
      at = Math.min(Math.max(to, 0), 1);
      const from = begun ?? at;
      cursor.style.left = `${100 * Math.min(from, at)}%`;
      cursor.style.width = `${100 * Math.abs(at - from)}%`;
      words.textContent = plot.readout(at, level);
      words.style.left = at < 0.5 ? "auto" : "0";
      words.style.right = at < 0.5 ? "0" : "auto";
      plot.frame.classList.add("read");
    };
    const zoom = (from, to) => {
      const [low, wide] = [plot.x.from, plot.x.to - plot.x.from];
      if (Math.abs(to - from) * wide < FEWEST) return;
      const ends = [low + Math.min(from, to) * wide, low + Math.max(from, to) * wide];
      groupOf(plot).forEach((other) => other.show(...ends));
    };
    const whole = () => groupOf(plot).forEach((other) => other.reset());
    plot.frame.addEventListener("pointermove", (event) => mark(share(event)));
    plot.frame.addEventListener("pointerdown", (event) => {
      begun = share(event);
    });
    plot.frame.addEventListener("pointerup", (event) => {
      if (begun !== null) zoom(begun, share(event));
      begun = null;
      mark(share(event));
    });
    plot.frame.addEventListener("pointerleave", () => {
      begun = null;
      plot.frame.classList.remove("read");
    });
    plot.frame.addEventListener("dblclick", whole);
    plot.frame.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
      if (step) mark(at + step);
      else if (event.key === "+") zoom(at - 0.25, at + 0.25);
      else if (event.key === "Escape") whole();
      else return;
      event.preventDefault();
    });
  }

  function save(figure) {
    const rows = ["line,x,y"];
    const inside = plots.filter((plot) => figure.contains(plot.root));
    const unit = inside.map((plot) => plot.title("xt")).find(Boolean) || "";
    for (const plot of inside) {
      rows[0] = `line,"${unit}",value`;
      const title = plot.title("yt");
      for (const line of plot.lines) {
        line.x.forEach((x, k) => {
          rows.push(`"${line.name}: ${title}",${plot.x.value(x)},${plot.y.value(line.y[k])}`);
        });
      }
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([`${rows.join("\n")}\n`], { type: "text/csv" }));
    link.download = `${figure.querySelector("figcaption").firstChild.textContent.trim()}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  function button(text, said, action) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = text;
    made.title = said;
    made.addEventListener("click", action);
    return made;
  }

  plots.forEach(listen);
  for (const figure of document.querySelectorAll("figure")) {
    if (plots.some((plot) => figure.contains(plot.root) && plot.lines.length)) {
      figure.querySelector("figcaption").append(
        button("CSV", "the points of this plot as drawn", () => save(figure)),
      );
    }
  }
  for (const entry of document.querySelectorAll(".legend span")) {
    const kind = entry.querySelector("path").classList[0];
    const area = entry.closest(".run, section");
    const paths = [...area.querySelectorAll(`.plot path.${kind}`)].filter(nameOf);
    if (!paths.length) continue;
    const word = entry.lastChild.textContent;
    entry.replaceChildren(entry.firstElementChild, button(word, "show or hide", () => {
      const off = entry.classList.toggle("off");
      paths.forEach((path) => path.classList.toggle("hidden", off));
    }));
  }
  document.body.classList.add("live");
})();
