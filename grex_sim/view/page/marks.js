// What is drawn of a craft: where it is, where it thinks it is, where its mates think it is.

import { label } from "./canvas.js";
import { colour, theme } from "./colours.js";

/** The true craft: an arrow head in the direction of the bow, with its name. */
export function drawCraft(context, place, name, shown, project) {
  const pose = shown?.true;
  if (!pose || pose[0] === null || pose[1] === null) return;
  const [x, y] = project(pose[0], pose[1]);
  context.save();
  context.translate(x, y);
  context.rotate(pose[3] ?? 0);
  context.beginPath();
  for (const [dx, dy] of [[0, -11], [7.5, 9], [0, 4.5], [-7.5, 9]]) context.lineTo(dx, dy);
  context.closePath();
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = theme.sea;
  context.stroke();
  context.fillStyle = colour(place);
  context.fill();
  context.restore();
  const beside = x > context.canvas.clientWidth - 60 ? -1 : 1; // at the right edge the name goes to the left
  const align = beside > 0 ? "left" : "right";
  label(context, name, x + 14 * beside, y - 13, theme.ink, theme.sea, { align, bold: true });
}

/** The own fix: a cross, and twice its standard deviation. */
export function drawFix(context, place, shown, project, scale) {
  const fix = shown?.own;
  if (!fix || fix[0] === null || fix[1] === null) return;
  const [x, y] = project(fix[0], fix[1]);
  context.strokeStyle = theme.ink;
  context.lineWidth = 1.2;
  context.beginPath();
  context.moveTo(x - 5, y);
  context.lineTo(x + 5, y);
  context.moveTo(x, y - 5);
  context.lineTo(x, y + 5);
  context.stroke();
  drawSpread(context, x, y, fix[2], scale, theme.ink, [1, 2]);
}

/** What mates believe of the others: rings in the colour of the craft they are about. */
export function drawBeliefs(context, names, shown, project, scale) {
  for (const [mate, belief] of Object.entries(shown?.mates ?? {})) {
    if (belief[0] === null || belief[1] === null) continue;
    const tint = colour(names.indexOf(mate));
    const [x, y] = project(belief[0], belief[1]);
    context.beginPath();
    context.arc(x, y, 9, 0, 2 * Math.PI);
    context.strokeStyle = tint;
    context.lineWidth = 1.6;
    context.stroke();
    drawSpread(context, x, y, belief[3], scale, tint, [4, 3]);
  }
}

/** Two standard deviations. Both axes have the same: the ellipse is a circle. */
function drawSpread(context, x, y, sigma, scale, tint, dashes) {
  const radius = 2 * (sigma ?? 0) * scale;
  if (!(radius > 10) || radius > 5000) return;
  context.setLineDash(dashes);
  context.strokeStyle = tint;
  context.lineWidth = 1.2;
  context.beginPath();
  context.ellipse(x, y, radius, radius, 0, 0, 2 * Math.PI);
  context.globalAlpha = 0.08;
  context.fillStyle = tint;
  context.fill();
  context.globalAlpha = 0.9;
  context.stroke();
  context.globalAlpha = 1;
  context.setLineDash([]);
}

/** A line through places. */
export function drawLine(context, points, project, tint, width, alpha, dashes = []) {
  context.beginPath();
  let drawing = false;
  for (const [north, east] of points) {
    if (north == null || east == null) {
      drawing = false;
      continue;
    }
    const [x, y] = project(north, east);
    if (drawing) context.lineTo(x, y);
    else context.moveTo(x, y);
    drawing = true;
  }
  context.globalAlpha = alpha;
  context.strokeStyle = tint;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.setLineDash(dashes);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

const TRAIL_POINTS = 300;

/** Where a craft has been: the past of its true places, as many as can be told apart. */
export function trail(past, name, until) {
  const [norths, easts] = [past.column(`north/${name}`), past.column(`east/${name}`)];
  const points = [];
  const step = Math.ceil(until / TRAIL_POINTS);
  for (let place = 0; place < until; place += step) points.push([norths[place], easts[place]]);
  return points;
}
