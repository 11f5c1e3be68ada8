// Puts the page together: a live run from the socket, or a recorded one from the server's pieces.

import { Charts } from "./charts.js";
import { onTheme } from "./colours.js";
import { showFigures, showPhase, showScene } from "./header.js";
import { Messages } from "./messages.js";
import { Past } from "./past.js";
import { Plan } from "./plan.js";
import { Player } from "./player.js";
import { Recording } from "./recording.js";
import { listen } from "./socket.js";
import { clearTables, showCraft, showHealth } from "./tables.js";
import { Timeline } from "./timeline.js";
import { drawWheel } from "./wheel.js";

const FRAME_MS = 30; // every second picture of a screen: as smooth as anybody sees, at half the work
const FIGURES_MS = 200;
const CHARTS_MS = 500;

class Page {
  constructor() {
    this.stale = true;
    this.plan = new Plan(document.getElementById("plan"), () => (this.stale = true));
    this.messages = new Messages(document.getElementById("messages"), document.getElementById("speaker"));
    this.figuresAt = this.chartsAt = -Infinity;
    this.drawn = 0; // frames drawn, for whoever measures
    new ResizeObserver(() => (this.stale = true)).observe(this.plan.canvas);
    onTheme(() => (this.stale = true));
  }

  begin(scene, past, charts) {
    [this.scene, this.past, this.charts] = [scene, past, charts];
    showScene(scene);
    clearTables();
    this.messages.clear();
    this.plan.begin(scene);
    charts.begin(scene);
    this.settle();
  }

  /** Let the next frame be drawn as it is to stay. */
  settle() {
    this.figuresAt = this.chartsAt = -Infinity;
    this.plan.settle();
  }

  /** Draw a frame; figures and charts less often than the plan. */
  show(frame, speed, wallMs) {
    this.plan.draw(frame, this.past);
    drawWheel(document.getElementById("wheel"), this.scene, frame);
    if (wallMs - this.figuresAt >= FIGURES_MS) {
      this.figuresAt = wallMs;
      showFigures(frame, speed);
      showCraft(frame, this.scene.craft);
      if (frame.health) showHealth(frame.health);
      this.messages.show(frame, this.scene);
    }
    if (wallMs - this.chartsAt >= CHARTS_MS) {
      this.chartsAt = wallMs;
      this.charts.show(this.past, frame.t);
    }
    this.drawn += 1;
  }
}

function startLive(page) {
  const timeline = new Timeline();
  const charts = new Charts(null);
  let [phase, reason, run] = ["waiting", "", -1];
  const take = (message) => {
    if (message.scene) {
      page.begin(message.scene, new Past(message.past), charts);
      run = message.run;
      return;
    }
    [phase, reason] = [message.phase, message.reason];
    showPhase(phase, reason);
    if (!message.craft || message.run !== run) return;
    timeline.push(message, performance.now());
    page.past.add(message.t, message.row);
  };
  listen(take, (state) => {
    if (state === "closed") showPhase("lost", "no connection to grex view; start it again, and this page comes back");
  });
  return (wallMs) => {
    const frame = timeline.at(wallMs);
    if (frame && page.scene) page.show(frame, phase === "running" ? frame.speed : NaN, wallMs);
  };
}

async function startRecorded(page, scene) {
  const past = new Past(await (await fetch("past.json")).json());
  const recording = new Recording(scene, () => (page.stale = true));
  const player = new Player(recording.start, recording.end, () => (page.stale = true));
  page.begin(scene, past, new Charts((seconds) => player.seek(seconds)));
  showPhase("recorded");
  let before = performance.now();
  return (wallMs) => {
    const moving = player.pass((wallMs - before) / 1000);
    before = wallMs;
    if (!moving && !page.stale) return;
    const frame = recording.at(player.now);
    if (!moving) page.settle();
    page.stale = false;
    if (frame) page.show(frame, player.speed, wallMs);
  };
}

const page = new Page();
const scene = await (await fetch("scene.json")).json();
const draw = scene.mode === "live" ? startLive(page) : await startRecorded(page, scene);
window.grexPage = page;
let drawnAt = -Infinity;
const loop = (wallMs) => {
  if (wallMs - drawnAt >= FRAME_MS) {
    drawnAt = wallMs;
    draw(wallMs);
  }
  requestAnimationFrame(loop);
};
requestAnimationFrame(loop);
