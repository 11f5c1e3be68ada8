// The chart's grid: round distances, with north up and numbers at the edge.

import { label } from "./canvas.js";
import { theme } from "./colours.js";

function roundStep(metres) {
  const power = 10 ** Math.floor(Math.log10(metres));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= metres);
}

export function drawGrid(context, width, height, camera) {
  const step = roundStep(90 / camera.scale);
  if (!Number.isFinite(step)) return;
  const [w, h] = [width / 2 / camera.scale, height / 2 / camera.scale];
  context.strokeStyle = theme.line;
  context.globalAlpha = 0.6;
  context.lineWidth = 1;
  context.beginPath();
  const texts = [];
  for (let east = Math.ceil((camera.east - w) / step) * step; east < camera.east + w; east += step) {
    const x = Math.round(width / 2 + (east - camera.east) * camera.scale) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
    if (x > 60 && x < width - 90) texts.push([Math.round(east * 100) / 100, x, height - 10, "center"]);
  }
  for (let north = Math.ceil((camera.north - h) / step) * step; north < camera.north + h; north += step) {
    const y = Math.round(height / 2 - (north - camera.north) * camera.scale) + 0.5;
    context.moveTo(0, y);
    context.lineTo(width, y);
    if (y > 24 && y < height - 24) texts.push([Math.round(north * 100) / 100, 6, y, "left"]);
  }
  context.stroke();
  context.globalAlpha = 1;
  const shown = (value) => String(value).replace("-", "−");
  for (const [value, x, y, align] of texts) label(context, shown(value), x, y, theme.soft, theme.sea, { align, size: 11 });
  label(context, "north m ↑", 6, 12, theme.soft, theme.sea, { size: 11 });
  label(context, "east m →", width - 6, height - 10, theme.soft, theme.sea, { align: "right", size: 11 });
}
