// Messages in the water: a front that grows from the sender, a dot on its way to each receiver, and how it ended.

import { label } from "./canvas.js";
import { colour, theme } from "./colours.js";
import { cause } from "./text.js";

/** Draw all messages of a frame. `project` takes north and east to pixels. Returns the causes of losses, for later. */
export function drawSounds(context, frame, names, project) {
  const causes = new Map();
  for (const sound of frame.sounds ?? []) drawSound(context, frame, names, project, sound, causes);
  return causes;
}

/** Write the causes above everything else; the newest at each receiver. */
export function drawCauses(context, causes) {
  for (const { x, y, text, share } of causes.values()) {
    context.globalAlpha = Math.min(1, 1.6 * share);
    label(context, text, x, y + 15, theme.red, theme.sea, { align: "center", bold: true });
  }
  context.globalAlpha = 1;
}

function drawSound(context, frame, names, project, sound, causes) {
  const from = sound.place ?? frame.craft[sound.source]?.true;
  if (!from || from[0] === null || sound.refused) return;
  const [x0, y0] = project(from[0], from[1]);
  const tint = colour(names.indexOf(sound.source));
  let [farthest, onAir] = [0, false];
  const here = names.filter((name) => name !== sound.source && frame.craft[name]?.true?.[0] != null);
  for (const name of here) {
    const end = sound.ends[name];
    const to = frame.craft[name].true;
    const [x1, y1] = project(to[0], to[1]);
    const lasting = end ? end[0] - sound.start_s : sound.lasting_s;
    const share = lasting > 0 ? Math.min(Math.max((frame.t - sound.start_s) / lasting, 0), 1) : 1;
    farthest = Math.max(farthest, Math.hypot(x1 - x0, y1 - y0));
    if (!end || frame.t < end[0]) {
      onAir = true;
      drawWay(context, x0, y0, x1, y1, share, tint);
    } else {
      const left = 1 - (frame.t - end[0]) / (frame.shown_s || 4);
      if (left > 0) drawEnd(context, x0, y0, x1, y1, end, left, tint, causes, name);
    }
  }
  if (onAir) drawFront(context, x0, y0, farthest, Math.min((frame.t - sound.start_s) / (sound.lasting_s || 1), 1), tint);
}

function drawFront(context, x, y, farthest, share, tint) {
  context.strokeStyle = tint;
  for (const [back, alpha] of [[0, 0.55], [0.1, 0.28], [0.2, 0.12]]) {
    const radius = (share - back) * Math.max(farthest, 24);
    if (radius <= 0) continue;
    context.globalAlpha = alpha;
    context.lineWidth = 1.6;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.stroke();
  }
  context.globalAlpha = 1;
}

function drawWay(context, x0, y0, x1, y1, share, tint) {
  const [x, y] = [x0 + (x1 - x0) * share, y0 + (y1 - y0) * share];
  context.strokeStyle = context.fillStyle = tint;
  context.globalAlpha = 0.5;
  context.lineWidth = 1.2;
  context.setLineDash([4, 4]);
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x, y);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fill();
}

function drawEnd(context, x0, y0, x1, y1, end, left, tint, causes, name) {
  const [, kind, reason] = end;
  context.globalAlpha = left;
  if (kind === "lost") {
    // Just before the receiver, where it would have been heard.
    const far = Math.hypot(x1 - x0, y1 - y0) || 1;
    const back = Math.min(20, far / 2) / far;
    const [x, y] = [x1 + (x0 - x1) * back, y1 + (y0 - y1) * back];
    context.strokeStyle = theme.red;
    context.lineWidth = 2.2;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(x - 5, y - 5 * side);
      context.lineTo(x + 5, y + 5 * side);
    }
    context.stroke();
    causes.set(name, { x, y, text: cause(reason), share: left });
  } else {
    context.strokeStyle = tint;
    context.lineWidth = kind === "delivered" ? 2.4 : 1;
    context.beginPath();
    context.arc(x1, y1, 12 + 10 * (1 - left), 0, 2 * Math.PI);
    context.stroke();
  }
  context.globalAlpha = 1;
}
