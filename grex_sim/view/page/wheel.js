// The slot wheel: one turn is a cycle; the hand is now, and whoever has the word is named in the middle.

import { fit, label } from "./canvas.js";
import { colour, theme } from "./colours.js";

const TOP = -Math.PI / 2;

export function drawWheel(canvas, scene, frame) {
  const cycle = scene.cycle_s;
  canvas.hidden = !cycle;
  if (!cycle) return;
  const fitted = fit(canvas);
  if (!fitted) return;
  const { context, width, height } = fitted;
  const [x, y, outer] = [width / 2, height / 2, Math.min(width, height) / 2 - 3];
  const speaking = new Set(speakers(frame).map((sound) => sound.source));
  const angle = (seconds) => TOP + (2 * Math.PI * seconds) / cycle;
  context.lineWidth = 16;
  context.strokeStyle = theme.faint;
  context.beginPath();
  context.arc(x, y, outer - 8, 0, 2 * Math.PI);
  context.stroke();
  for (const [name, start, length] of scene.slots) {
    const gap = scene.slots.length > 1 ? Math.min(0.03, Math.PI / scene.slots.length / 4) : 0;
    context.beginPath();
    context.arc(x, y, outer - 8, angle(start) + gap, angle(start + length) - gap);
    context.strokeStyle = colour(scene.craft.indexOf(name));
    context.globalAlpha = speaking.has(name) ? 1 : 0.32;
    context.stroke();
  }
  context.globalAlpha = 1;
  const now = angle(frame.t % cycle);
  context.strokeStyle = theme.ink;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x + Math.cos(now) * (outer - 24), y + Math.sin(now) * (outer - 24));
  context.lineTo(x + Math.cos(now) * outer, y + Math.sin(now) * outer);
  context.stroke();
  const owner = scene.slots.find(([, start, length]) => {
    const within = (((frame.t - start) % cycle) + cycle) % cycle;
    return within < length;
  });
  label(context, owner?.[0] ?? "–", x, y - 7, theme.ink, theme.panel, { align: "center", size: 15, bold: true });
  const hint = speaking.size ? "speaking" : owner ? "its slot" : "guard";
  label(context, hint, x, y + 11, theme.soft, theme.panel, { align: "center", size: 11 });
}

/** What is on the air at the moment of a frame. */
export function speakers(frame) {
  return (frame.sounds ?? []).filter(
    (sound) => !sound.refused && sound.start_s <= frame.t && frame.t < sound.start_s + sound.lasting_s);
}
