// The newest messages as a list: who, when, and what became of it at whom.

import { cause, time, write } from "./text.js";
import { speakers } from "./wheel.js";

const MOST = 40;

export class Messages {
  constructor(list, line) {
    [this.list, this.line] = [list, line];
    this.rows = new Map();
  }

  clear() {
    this.rows.clear();
    this.list.replaceChildren();
  }

  show(frame, scene) {
    const now = speakers(frame).map((sound) => sound.source);
    write(this.line, now.length ? `${[...new Set(now)].join(", ")} speaking` : "silence");
    const heard = new Set((frame.sounds ?? []).map((sound) => sound.id));
    for (const sound of frame.sounds ?? []) {
      if (sound.start_s <= frame.t) this.row(sound, frame, scene);
    }
    for (const [id, row] of this.rows) {
      // The slider went back; or on, past the end of this message, which nobody has seen.
      if (row.start > frame.t || (row.open && !heard.has(id))) this.drop(id);
    }
    while (this.rows.size > MOST) this.drop(this.rows.keys().next().value);
  }

  drop(id) {
    this.rows.get(id)?.item.remove();
    this.rows.delete(id);
  }

  row(sound, frame, scene) {
    let row = this.rows.get(sound.id);
    if (!row || row.start !== sound.start_s) {
      this.drop(sound.id);
      const item = document.createElement("li");
      const stamp = document.createElement("time");
      const text = document.createElement("span");
      stamp.textContent = time(sound.start_s);
      item.append(stamp, text);
      row = { item, text, start: sound.start_s, said: "" };
      this.rows.set(sound.id, row);
      this.list.prepend(item);
    }
    const parts = this.parts(sound, frame, scene);
    const said = JSON.stringify(parts);
    row.open = parts.at(-1)[1] === "air";
    if (said === row.said) return;
    row.said = said;
    row.text.replaceChildren(...parts.map(([text, kind]) => {
      const span = document.createElement("span");
      span.textContent = `${text} `;
      if (kind) span.className = kind;
      return span;
    }));
  }

  parts(sound, frame, scene) {
    const what = sound.purpose === "data" ? "" : ` ${sound.purpose}`;
    const parts = [[`${sound.source}${what}`, ""]];
    if (sound.refused) return [...parts, [`refused: ${cause(sound.refused)}`, "lost"]];
    const ends = Object.entries(sound.ends).filter(([, end]) => end[0] <= frame.t);
    for (const [who, [, kind, reason]] of ends) {
      if (kind === "lost") parts.push([`✕ ${who}: ${cause(reason)}`, "lost"]);
      else if (kind === "delivered") parts.push([`✓ ${who}`, "got"]);
    }
    const waiting = sound.purpose === "land" ? 1 : scene.craft.length - 1;
    if (ends.length < waiting) parts.push([frame.t < sound.start_s + sound.lasting_s ? "on the air …" : "…", "air"]);
    return parts;
  }
}
