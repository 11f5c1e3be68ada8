// The whole plan in a corner, while the team is seen closely. What changes slowly has a canvas of its own.

import { Camera } from "./camera.js";
import { colour, theme } from "./colours.js";
import { drawLine } from "./marks.js";

const EVERY_MS = 500;

export class Inset {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.drawnAt = -Infinity;
  }

  /** Draw it anew at the next opportunity. */
  settle() {
    this.drawnAt = -Infinity;
  }

  /** Draw it at the upper right; `seen` is the camera of the large view. */
  draw(context, width, height, plans, names, frame, seen, trails) {
    const [w, h] = [Math.round(Math.min(190, width * 0.3)), Math.round(Math.min(190, height * 0.36))];
    const camera = new Camera();
    camera.aim(Object.values(plans).flat(), w + 50, h + 50, 10, 1);
    const project = camera.project(w, h);
    const now = performance.now();
    if (now - this.drawnAt >= EVERY_MS || this.size !== `${w}x${h}`) {
      [this.drawnAt, this.size] = [now, `${w}x${h}`];
      this.drawGround(w, h, plans, names, trails, project);
    }
    context.save();
    context.translate(width - w - 10, 10);
    context.drawImage(this.canvas, 0, 0, w, h);
    context.beginPath();
    context.rect(0, 0, w, h);
    context.clip();
    names.forEach((name, place) => {
      const pose = frame.craft[name]?.true;
      if (!pose || pose[0] === null || pose[1] === null) return;
      const [x, y] = project(pose[0], pose[1]);
      context.fillStyle = colour(place);
      context.beginPath();
      context.arc(x, y, 3, 0, 2 * Math.PI);
      context.fill();
    });
    const [x0, y0] = project(seen.north + height / 2 / seen.scale, seen.east - width / 2 / seen.scale);
    context.strokeStyle = theme.ink;
    context.lineWidth = 1;
    context.strokeRect(x0, y0, (width / seen.scale) * camera.scale, (height / seen.scale) * camera.scale);
    context.restore();
  }

  drawGround(w, h, plans, names, trails, project) {
    const ratio = Math.min(devicePixelRatio || 1, 2);
    Object.assign(this.canvas, { width: w * ratio, height: h * ratio });
    const context = this.canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.beginPath();
    context.roundRect(0.5, 0.5, w - 1, h - 1, 6);
    context.globalAlpha = 0.92;
    context.fillStyle = theme.panel;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = theme.line;
    context.stroke();
    names.forEach((name, place) => {
      drawLine(context, plans[name], project, theme.soft, 0.7, 0.5);
      drawLine(context, trails[place], project, colour(place), 1.4, 0.9);
    });
  }
}
