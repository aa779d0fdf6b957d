// The plots: one strip a channel, one line of time for all of them.

const LABELS = {
  current: "current", terminal_voltage: "voltage", supply_voltage: "supply",
  position: "position", speed: "speed",
};
const SHRINK = 0.4; // of the axis: less than this of it in use, and it is fitted anew
const CLICK_PX = 4; // a drag that is shorter is a click

export const label = (channel) => channel.label ?? LABELS[channel.name] ?? channel.name;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Strips {
  // `zoom(from, to)`, `click(time)`, `wheel(time, factor)` and `follow()` are what a hand asks for.
  constructor(root, channels, hands) {
    this.root = root;
    this.hands = hands;
    this.ranges = channels.map(() => null);
    this.marks = () => [];
    root.replaceChildren();
    this.plots = channels.map((channel, c) => this.#plot(channel, c, channels.length));
    this.watcher = new ResizeObserver(() => this.#resize());
    this.watcher.observe(root);
  }

  destroy() {
    this.watcher.disconnect();
    for (const plot of this.plots) plot.destroy();
  }

  get width() { return Math.max(50, this.plots[0] ? this.plots[0].over.clientWidth : 50); }

  draw(from, to, { xs, ys }) {
    this.view = [from, to];
    this.plots.forEach((plot, c) => {
      this.ranges[c] = fitted(this.ranges[c], ys[c]);
      plot.batch(() => {
        plot.setData([xs, ys[c]], false);
        plot.setScale("x", { min: from, max: to });
        plot.setScale("y", { min: this.ranges[c][0], max: this.ranges[c][1] });
      });
    });
  }

  // After a change of colours or marks.
  redraw() { for (const plot of this.plots) plot.redraw(false, true); }

  #plot(channel, c, count) {
    const host = document.createElement("div");
    host.className = "strip";
    host.dataset.channel = channel.name;
    this.root.append(host);
    const colour = () => css(`--c-${channel.name}`) || css("--ink");
    const axis = { stroke: () => css("--soft"), grid: { stroke: () => css("--line"), width: 1 },
      ticks: { stroke: () => css("--line") }, font: "12px system-ui, sans-serif" };
    const last = c === count - 1;
    const options = {
      ...this.#size(host),
      legend: { show: false },
      cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, points: { show: false } },
      scales: { x: { time: false, auto: false }, y: { auto: false } },
      axes: [
        { ...axis, size: last ? 32 : 8, values: last ? seconds : () => [] },
        { ...axis, size: 64, values: decimals, label: `${label(channel)}, ${channel.unit}`, labelSize: 18, labelFont: axis.font },
      ],
      series: [{}, { stroke: colour, width: 1.25, points: { show: false }, spanGaps: false }],
      hooks: {
        setSelect: [(plot) => this.#selected(plot)],
        draw: [(plot) => this.#mark(plot, c)],
      },
    };
    const plot = new uPlot(options, [[], []], host);
    this.#listen(plot);
    return plot;
  }

  #listen(plot) {
    const time = (event) => plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
    let down = 0;
    plot.over.addEventListener("mousedown", (event) => { down = event.clientX; });
    plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) < CLICK_PX) this.hands.click(time(event), event.shiftKey);
    });
    plot.over.addEventListener("dblclick", () => this.hands.follow());
    plot.over.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.hands.wheel(time(event), event.deltaY > 0 ? 1.25 : 0.8);
    }, { passive: false });
  }

  #selected(plot) {
    const { left, width } = plot.select;
    if (width < CLICK_PX) return;
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.hands.zoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
  }

  // Cursors and the trigger: {time or level, colour, text, channel}.
  #mark(plot, c) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = devicePixelRatio;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    for (const mark of this.marks()) {
      if (mark.channel !== undefined && mark.channel !== c) continue;
      ctx.strokeStyle = ctx.fillStyle = css(mark.colour);
      ctx.setLineDash(mark.dashed ? [4 * devicePixelRatio, 4 * devicePixelRatio] : []);
      ctx.beginPath();
      if (mark.time !== undefined) {
        const x = plot.valToPos(mark.time, "x", true);
        ctx.moveTo(x, bbox.top); ctx.lineTo(x, bbox.top + bbox.height);
        if (c === 0) ctx.fillText(mark.text, x + 4 * devicePixelRatio, bbox.top + 13 * devicePixelRatio);
      } else {
        const y = plot.valToPos(mark.level, "y", true);
        ctx.moveTo(bbox.left, y); ctx.lineTo(bbox.left + bbox.width, y);
      }
      ctx.stroke();
    }
    ctx.restore();
  }

  #size(host) {
    return { width: Math.max(200, this.root.clientWidth), height: Math.max(90, host.clientHeight) };
  }

  #resize() {
    for (const plot of this.plots) plot.setSize(this.#size(plot.root.parentElement));
  }
}

// The y axis for these values: kept as it is while they fit and use enough of it.
function fitted(range, values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value === null) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return range ?? [-1, 1];
  const used = high - low;
  if (range && low >= range[0] && high <= range[1] && used > SHRINK * (range[1] - range[0])) return range;
  const room = used ? 0.08 * used : Math.max(Math.abs(high) * 0.05, 1e-3);
  return [low - room, high + room];
}

// Labels with as many digits as tell one from the next.
function decimals(plot, splits) {
  const step = splits.length > 1 ? Math.abs(splits[1] - splits[0]) : 1;
  let digits = 0;
  while (digits < 7 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6) digits++;
  return splits.map((one) => one.toFixed(digits).replace("-", "−"));
}

function seconds(plot, splits) {
  return decimals(plot, splits).map((one) => `${one} s`);
}
