// The strip charts, drawn by uPlot: fd(k) and its parts, Θ against the team, cross-track error, age of information.

import { colour, dash, onTheme, theme } from "./colours.js";
import { time } from "./text.js";

const uPlot = window.uPlot;
const NEWEST_S = 600; // live: so much of the past, and all of it in a recording
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 18000, 36000, 86400];
const LEAST = 0.02; // below it there is nothing to see, and the numbers at the axis would be the same
const FD = [["fd", "fd(k)", "ink", 1.6, []], ["fd/distance", "distance", "#0072B2", 1.2, []],
  ["fd/angle", "angle", "#D55E00", 1.2, [5, 3]], ["fd/cross-track", "cross-track", "#009E73", 1.2, [2, 2]]];

/** Chips that say which line is whose. */
function chip(name, stroke, dashes) {
  const span = document.createElement("span");
  span.className = "chip";
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
  const sides = { x1: 0, x2: 18, y1: 4, y2: 4, stroke, "stroke-width": 2.4, "stroke-dasharray": dashes.join(" ") };
  for (const [side, value] of Object.entries(sides)) line.setAttribute(side, value);
  svg.append(line);
  span.append(svg, name);
  return span;
}

class Chart {
  constructor(figure, title, unit, seek) {
    Object.assign(this, { figure, title, unit, seek, lines: [] });
    this.caption = document.createElement("figcaption");
    this.plot = document.createElement("div");
    this.plot.className = "plot";
    figure.replaceChildren(this.caption, this.plot);
    figure.setAttribute("aria-label", `${title}, ${unit}`);
    new ResizeObserver(() => this.resize()).observe(this.plot);
  }

  begin(lines, extra = null) {
    this.lines = lines;
    const name = Object.assign(document.createElement("b"), { textContent: this.title });
    const unit = Object.assign(document.createElement("span"), { className: "unit", textContent: this.unit });
    const chips = lines.slice(0, 8).map(([, text, stroke, , dashes]) => chip(text, stroke === "ink" ? theme.ink : stroke, dashes));
    const more = lines.length > 8 ? [`and ${lines.length - 8} more`] : [];
    this.caption.replaceChildren(name, unit, ...(extra ? [extra] : []), ...chips, ...more);
    this.chart?.destroy();
    this.chart = null;
    this.resize();
  }

  resize() {
    const size = { width: this.plot.clientWidth, height: this.plot.clientHeight };
    if (size.width < 20 || size.height < 20 || !this.lines.length) return;
    if (this.chart) this.chart.setSize(size);
    else this.chart = new uPlot(this.options(size), [[], ...this.lines.map(() => [])], this.plot);
    if (this.data) this.chart.setData(this.data);
  }

  options(size) {
    const axis = { stroke: () => theme.soft, grid: { stroke: () => theme.faint, width: 1 }, ticks: { show: false },
      font: "11px system-ui, 'DejaVu Sans', sans-serif" };
    const series = this.lines.map(([, label, stroke, width, dashes]) => ({
      label, stroke: () => (stroke === "ink" ? theme.ink : stroke), width, dash: dashes, points: { show: false } }));
    return {
      ...size,
      padding: [6, 10, 0, 0],
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false }, sync: { key: "strips" } },
      scales: { x: { time: false }, y: { range: (_, low, high) => this.span(low, high) } },
      axes: [
        { ...axis, size: 26, gap: 6, space: 70, incrs: STEPS_S, values: (_, ticks) => ticks.map(time) },
        { ...axis, size: 46, gap: 4, space: 24 },
      ],
      series: [{}, ...series],
      hooks: {
        draw: [(chart) => this.drawNow(chart)],
        ready: [(chart) => chart.over.addEventListener("click", () => this.seek?.(chart.posToVal(chart.cursor.left, "x")))],
      },
    };
  }

  span(low, high) {
    if (low === null || high === null || !Number.isFinite(high - low)) return [0, 1];
    const room = Math.max((high - low) * 0.08, (LEAST - (high - low)) / 2, Math.abs(high) * 1e-3);
    return [low >= 0 ? 0 : low - room, high + room];
  }

  drawNow(chart) {
    if (this.now === undefined || !this.seek) return;
    const x = chart.valToPos(this.now, "x", true);
    const { left, top, width, height } = chart.bbox;
    if (x < left || x > left + width) return;
    chart.ctx.fillStyle = theme.ink;
    chart.ctx.fillRect(Math.round(x), top, Math.max(1, devicePixelRatio), height);
  }

  show(past, first, now) {
    this.data = [past.columns[0], ...this.lines.map(([name]) => past.column(name))].map((column) => column.slice(first));
    this.now = now;
    this.chart?.setData(this.data);
  }

  mark(now) {
    this.now = now;
    this.chart?.redraw(false, false);
  }
}

export class Charts {
  /** `seek` is called with a mission time when somebody points at one; null for a live run. */
  constructor(seek) {
    const make = (id, title, unit) => new Chart(document.getElementById(id), title, unit, seek);
    this.fd = make("chart-fd", "Formation deviation", "m, rad");
    this.theta = make("chart-theta", "Θ − team mean", "tracks");
    this.xte = make("chart-xte", "Cross-track error", "m");
    this.age = make("chart-age", "Age of information", "s");
    this.all = [this.fd, this.theta, this.xte, this.age];
    this.live = !seek;
    onTheme(() => this.scene && this.begin(this.scene));
  }

  begin(scene) {
    this.scene = scene;
    const lines = (kind) => scene.craft.map((name, place) => [`${kind}/${name}`, name, colour(place), 1.4, dash(place)]);
    this.fd.begin(FD);
    this.theta.begin(lines("theta"));
    this.xte.begin(lines("xte"));
    this.beginAge(scene, lines);
    this.version = -1;
  }

  beginAge(scene, lines) {
    if (!scene.pairs.length) {
      this.age.begin(lines("age"));
      return;
    }
    const select = document.createElement("select");
    select.setAttribute("aria-label", "Age of information at which craft");
    select.replaceChildren(...scene.craft.map((name) => new Option(`at ${name}`, name)));
    select.value = scene.craft.includes(this.knower) ? this.knower : scene.craft[0];
    this.knower = select.value;
    const mates = scene.craft.filter((name) => name !== this.knower);
    const look = (name) => [colour(scene.craft.indexOf(name)), 1.4, dash(scene.craft.indexOf(name))];
    this.age.begin(mates.map((name) => [`age/${this.knower}/${name}`, `of ${name}`, ...look(name)]), select);
    select.addEventListener("change", () => {
      this.knower = select.value;
      this.beginAge(scene, lines);
      this.version = -1;
      this.age.caption.querySelector("select").focus();
    });
  }

  show(past, now) {
    if (this.version === past.version && this.past === past) {
      if (!this.live) for (const chart of this.all) chart.mark(now);
      return;
    }
    [this.version, this.past] = [past.version, past];
    const first = this.live ? past.until((past.columns[0].at(-1) ?? 0) - NEWEST_S) : 0;
    for (const chart of this.all) chart.show(past, first, now);
  }
}
