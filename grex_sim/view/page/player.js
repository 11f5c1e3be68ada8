// The clock of a recording: play, pause, speed, slider.

import { time, write } from "./text.js";

const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200, 500];
/** Played from beginning to end in about so many seconds, if nobody chooses. */
const WHOLE_S = 150;

export class Player {
  constructor(start, end, moved) {
    [this.start, this.end, this.now] = [start, end, start];
    this.moved = moved;
    this.playing = false;
    const byId = (id) => document.getElementById(id);
    [this.button, this.slider, this.clock, this.pace] = ["play", "slider", "clock", "pace"].map(byId);
    byId("player").hidden = false;
    Object.assign(this.slider, { min: start, max: end, step: end - start > 120 ? 1 : 0.1 });
    const best = SPEEDS.reduce((a, b) => (Math.abs(b * WHOLE_S - end) < Math.abs(a * WHOLE_S - end) ? b : a));
    for (const speed of SPEEDS) this.pace.add(new Option(`${speed} ×`, speed, speed === best, speed === best));
    this.speed = best;
    this.pace.addEventListener("change", () => (this.speed = Number(this.pace.value)));
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value), true));
    addEventListener("keydown", (event) => this.onKey(event));
    this.show();
  }

  onKey(event) {
    const taken = ["BUTTON", "SELECT"].includes(event.target.tagName); // there a space has its own meaning
    if (event.key === " " && !taken) {
      event.preventDefault();
      this.play(!this.playing);
    }
  }

  play(on) {
    if (on && this.now >= this.end) this.seek(this.start);
    this.playing = on;
    write(this.button, on ? "Pause" : "Play");
    this.button.setAttribute("aria-pressed", String(on));
  }

  seek(seconds, bySlider = false) {
    this.now = Math.min(Math.max(seconds, this.start), this.end);
    this.show(bySlider);
    this.moved();
  }

  /** Let so many wall seconds pass; whether the picture is another one. */
  pass(wallS) {
    if (!this.playing) return false;
    this.now = Math.min(this.now + wallS * this.speed, this.end);
    if (this.now >= this.end) this.play(false);
    this.show();
    return true;
  }

  show(bySlider = false) {
    if (!bySlider) this.slider.value = this.now;
    this.slider.setAttribute("aria-valuetext", `mission time ${time(this.now)}`);
    write(this.clock, `${time(this.now)} / ${time(this.end)}`);
  }
}
