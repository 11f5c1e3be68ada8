// The plan view: draws a frame, and is moved with keys, mouse and fingers.

import { Camera } from "./camera.js";
import { fit } from "./canvas.js";
import { drawGrid } from "./grid.js";
import { Inset } from "./inset.js";
import { colour, dash } from "./colours.js";
import { drawBeliefs, drawCraft, drawFix, drawLine, trail } from "./marks.js";
import { drawCauses, drawSounds } from "./sounds.js";

const TEAM_LEAST_M = 30;
const STEP_PX = 60;

export class Plan {
  constructor(canvas, redraw) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.redraw = redraw;
    this.aimed = false;
    this.inset = new Inset();
    this.observer = document.getElementById("observer");
    this.observer.addEventListener("change", redraw);
    this.listen();
  }

  /** Let the next frame be drawn as it is to stay. */
  settle() {
    this.aimed = false;
    this.inset.settle();
  }

  begin(scene) {
    this.names = scene.craft;
    this.plans = scene.plan;
    this.settle();
    const chosen = this.observer.value;
    this.observer.replaceChildren(new Option("all", ""), ...scene.craft.map((name) => new Option(name, name)));
    this.observer.value = scene.craft.includes(chosen) ? chosen : "";
  }

  draw(frame, past) {
    const fitted = fit(this.canvas);
    if (!fitted || !this.names || !frame?.craft) return;
    const { context, width, height } = fitted;
    this.aim(frame, width, height);
    const project = this.camera.project(width, height);
    drawGrid(context, width, height, this.camera);
    const until = past.until(frame.t);
    const trails = this.names.map((name) => trail(past, name, until));
    this.names.forEach((name, place) => {
      drawLine(context, this.plans[name], project, colour(place), 1, 0.35);
      const here = frame.craft[name]?.true;
      const points = here?.[0] != null ? [...trails[place], here] : trails[place];
      drawLine(context, points, project, colour(place), 2, 0.85, dash(place));
    });
    const causes = drawSounds(context, frame, this.names, project);
    for (const name of this.names) {
      const seen = this.observer.value;
      if (!seen || seen === name) drawBeliefs(context, this.names, frame.craft[name], project, this.camera.scale);
    }
    this.names.forEach((name, place) => drawCraft(context, place, name, frame.craft[name], project));
    this.names.forEach((name, place) => drawFix(context, place, frame.craft[name], project, this.camera.scale));
    drawCauses(context, causes);
    // On a phone it would lie on the team; the button "Whole plan" shows the same.
    if (this.camera.mode !== "whole" && width >= 480) {
      this.inset.draw(context, width, height, this.plans, this.names, frame, this.camera, trails);
    }
  }

  aim(frame, width, height) {
    const { camera } = this;
    if (camera.mode === "free") return;
    const places = this.names.map((name) => frame.craft[name]?.true).filter((pose) => pose && pose[0] !== null);
    const whole = camera.mode === "whole" || !places.length;
    const points = whole ? Object.values(this.plans).flat().concat(places) : places;
    camera.aim(points, width, whole ? height : height * 0.9, whole ? 20 : TEAM_LEAST_M, this.aimed ? 0.1 : 1);
    this.aimed = true;
  }

  show(mode) {
    Object.assign(this.camera, { mode, zoom: 1 });
    this.aimed = false;
    this.mark();
  }

  mark() {
    for (const mode of ["team", "whole"]) {
      document.getElementById(mode).setAttribute("aria-pressed", String(this.camera.mode === mode));
    }
    this.redraw();
  }

  magnify(factor) {
    this.camera.magnify(factor);
    this.aimed = false;
    this.redraw();
  }

  move(across, up) {
    this.camera.move(across, up);
    this.mark();
  }

  listen() {
    const on = (id, act) => document.getElementById(id).addEventListener("click", act);
    on("team", () => this.show("team"));
    on("whole", () => this.show("whole"));
    on("closer", () => this.magnify(1.4));
    on("farther", () => this.magnify(1 / 1.4));
    const keys = {
      ArrowLeft: () => this.move(-STEP_PX, 0), ArrowRight: () => this.move(STEP_PX, 0),
      ArrowUp: () => this.move(0, STEP_PX), ArrowDown: () => this.move(0, -STEP_PX),
      "+": () => this.magnify(1.4), "=": () => this.magnify(1.4), "-": () => this.magnify(1 / 1.4),
      0: () => this.show("whole"), t: () => this.show("team"),
    };
    this.canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      keys[event.key]();
    });
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== this.canvas) return; // the page scrolls until the plan is chosen
      event.preventDefault();
      this.magnify(event.deltaY < 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1 && event.pointerType !== "touch") this.move(-event.movementX, event.movementY);
    });
  }
}
