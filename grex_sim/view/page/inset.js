// The whole plan in a corner, while the team is seen closely.

import { Camera } from "./camera.js";
import { colour, theme } from "./colours.js";
import { drawLine } from "./marks.js";

/** Draw it at the upper right; `seen` is the camera of the large view. */
export function drawInset(context, width, height, plans, names, frame, seen, trails) {
  const [w, h] = [Math.min(190, width * 0.3), Math.min(190, height * 0.36)];
  const left = width - w - 10;
  context.save();
  context.translate(left, 10);
  context.beginPath();
  context.roundRect(0, 0, w, h, 6);
  context.fillStyle = theme.panel;
  context.globalAlpha = 0.92;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = theme.line;
  context.lineWidth = 1;
  context.stroke();
  context.clip();
  const camera = new Camera();
  camera.aim(Object.values(plans).flat(), w + 50, h + 50, 10, 1);
  const project = camera.project(w, h);
  names.forEach((name, place) => {
    drawLine(context, plans[name], project, theme.soft, 0.7, 0.5);
    drawLine(context, trails[place], project, colour(place), 1.4, 0.9);
  });
  names.forEach((name, place) => {
    const pose = frame.craft[name]?.true;
    if (!pose || pose[0] === null) return;
    const [x, y] = project(pose[0], pose[1]);
    context.fillStyle = colour(place);
    context.beginPath();
    context.arc(x, y, 3, 0, 2 * Math.PI);
    context.fill();
  });
  const [x0, y0] = project(seen.north + height / 2 / seen.scale, seen.east - width / 2 / seen.scale);
  const [across, down] = [(width / seen.scale) * camera.scale, (height / seen.scale) * camera.scale];
  context.strokeStyle = theme.ink;
  context.lineWidth = 1;
  context.strokeRect(x0, y0, across, down);
  context.restore();
}
