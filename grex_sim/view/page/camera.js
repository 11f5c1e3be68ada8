// Which part of the sea is seen: follows the team, shows the whole plan, or stays where it was moved to.

/** North is up: metres to pixels. */
export class Camera {
  constructor() {
    Object.assign(this, { north: 0, east: 0, scale: 1, mode: "team", zoom: 1 });
  }

  /** Place so that points (north, east) are seen, and not closer than so many metres. The scale goes a `share` of its
   *  way, 1 at once: it would twitch with every turn of the team. */
  aim(points, width, height, leastM, share) {
    if (!points.length) return;
    const norths = points.map((point) => point[0]);
    const easts = points.map((point) => point[1]);
    const [n0, n1] = [Math.min(...norths), Math.max(...norths)];
    const [e0, e1] = [Math.min(...easts), Math.max(...easts)];
    const [w, h] = [Math.max(width - 70, 40), Math.max(height - 70, 40)];
    const scale = Math.min(h / Math.max(n1 - n0, leastM), w / Math.max(e1 - e0, leastM)) * this.zoom;
    [this.north, this.east] = [(n0 + n1) / 2, (e0 + e1) / 2];
    this.scale *= (scale / this.scale) ** share;
  }

  project(width, height) {
    return (north, east) => [
      width / 2 + (east - this.east) * this.scale,
      height / 2 - (north - this.north) * this.scale,
    ];
  }

  magnify(factor) {
    if (this.mode === "free") this.scale = Math.min(Math.max(this.scale * factor, 1e-3), 1e4);
    else this.zoom = Math.min(Math.max(this.zoom * factor, 0.05), 50);
  }

  move(acrossPx, upPx) {
    this.mode = "free";
    this.east += acrossPx / this.scale;
    this.north += upPx / this.scale;
  }
}
