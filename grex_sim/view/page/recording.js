// A recorded run: fetches the frames in pieces as they are needed, and keeps the latest of them.

import { between } from "./timeline.js";

const KEPT = 12;

export class Recording {
  /** `arrived` is called when a piece that was missing is there. */
  constructor(scene, arrived) {
    this.times = scene.times;
    this.size = scene.frames_a_piece;
    this.pieces = new Map();
    this.coming = new Set();
    this.arrived = arrived;
    this.shown = null;
  }

  get end() {
    return this.times.at(-1) ?? 0;
  }

  get start() {
    return this.times[0] ?? 0;
  }

  /** The picture at a mission time; the one before as long as this one is on its way. */
  at(seconds) {
    const index = this.indexAt(seconds);
    const early = this.frame(index);
    const late = index + 1 < this.times.length ? this.frame(index + 1) : early;
    if (early && late) {
      const span = late.t - early.t;
      this.shown = span > 0 ? between(early, late, Math.min(Math.max((seconds - early.t) / span, 0), 1)) : early;
      if (this.shown !== early) this.shown.sounds = late.sounds;
    }
    return this.shown;
  }

  indexAt(seconds) {
    let [low, high] = [0, this.times.length - 1];
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.times[middle] <= seconds) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  frame(index) {
    const number = Math.floor(index / this.size);
    const piece = this.pieces.get(number);
    if (!piece) {
      this.fetch(number);
      return null;
    }
    if (index % this.size > this.size / 2 && (number + 1) * this.size < this.times.length) this.fetch(number + 1);
    this.pieces.delete(number); // the piece used last is the last to go
    this.pieces.set(number, piece);
    return piece[index % this.size];
  }

  async fetch(number) {
    if (this.coming.has(number) || this.pieces.has(number)) return;
    this.coming.add(number);
    try {
      const answer = await fetch(`frames/${number}.json`);
      if (!answer.ok) throw new Error(`piece ${number}: status ${answer.status}`);
      this.pieces.set(number, await answer.json());
      if (this.pieces.size > KEPT) this.pieces.delete(this.pieces.keys().next().value);
      this.arrived();
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 1000)); // the server may be gone for a moment
    } finally {
      this.coming.delete(number);
    }
  }
}
