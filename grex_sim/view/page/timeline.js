// Frames of a live run, and what lies between two of them: places move smoothly, everything else is the newest.

const KEPT = 30;

/** Places between two frames: a copy of the later one with the places of a moment in between. */
export function between(a, b, share) {
  const craft = {};
  for (const [name, late] of Object.entries(b.craft)) {
    const early = a.craft[name];
    craft[name] = { ...late };
    for (const kind of ["true", "own"]) {
      if (early?.[kind] && late[kind]) craft[name][kind] = mixed(early[kind], late[kind], share, kind === "true");
    }
    if (early?.mates && late.mates) {
      craft[name].mates = { ...late.mates };
      for (const [mate, belief] of Object.entries(late.mates)) {
        if (early.mates[mate]) craft[name].mates[mate] = mixed(early.mates[mate], belief, share, false);
      }
    }
  }
  return { ...b, t: a.t + (b.t - a.t) * share, craft };
}

function mixed(early, late, share, turning) {
  const values = late.map((value, place) =>
    value === null || early[place] === null ? value : early[place] + (value - early[place]) * share);
  if (turning && late[3] !== null && early[3] !== null) {
    const turn = Math.atan2(Math.sin(late[3] - early[3]), Math.cos(late[3] - early[3]));
    values[3] = early[3] + turn * share;
  }
  return values;
}

/** Plays live frames one step behind, as fast as they come. */
export class Timeline {
  constructor() {
    this.frames = [];
  }

  push(frame, wallMs) {
    const last = this.frames.at(-1);
    if (last && (frame.t < last.frame.t || frame.run !== last.frame.run)) this.frames = [];
    if (this.frames.length && frame.t === this.frames.at(-1).frame.t) this.frames.at(-1).frame = frame;
    else this.frames.push({ frame, wallMs });
    if (this.frames.length > KEPT) this.frames.shift();
  }

  /** The picture at a wall time, or null if there is none yet. */
  at(wallMs) {
    const count = this.frames.length;
    if (count < 2) return this.frames[0]?.frame ?? null;
    const [early, late] = [this.frames[count - 2], this.frames[count - 1]];
    const lasting = Math.min(late.wallMs - early.wallMs, 3000);
    const share = lasting > 0 ? Math.min((wallMs - late.wallMs) / lasting, 1) : 1;
    return share >= 1 ? late.frame : between(early.frame, late.frame, Math.max(share, 0));
  }
}
