// The first line: what is run, how it stands, when, how fast, how well.

import { number, time, write } from "./text.js";

const WORDS = { waiting: "waiting for a run", running: "running", over: "over", lost: "lost", fault: "broken off" };
const byId = (id) => document.getElementById(id);

export function showScene(scene) {
  const title = scene.title || scene.name || scene.team;
  write(byId("title"), title);
  document.title = `GREX · ${title}`;
}

/** Phase of the run, or of the connection to the server. */
export function showPhase(phase, reason = "") {
  const shown = phase === "over" && reason ? "fault" : phase;
  byId("phase").dataset.phase = shown;
  write(byId("phase"), WORDS[shown] ?? shown);
  byId("reason").hidden = !reason;
  write(byId("reason"), reason);
}

export function showFigures(frame, speed) {
  write(byId("time"), time(frame.t));
  write(byId("speed"), Number.isFinite(speed) ? `${number(speed, speed < 10 ? 1 : 0)} ×` : "–");
  write(byId("fd"), number(frame.fd?.[0], 3));
  const bad = [];
  if (frame.bad) bad.push(`${frame.bad} messages did not decode`);
  if (frame.dropped) bad.push(`${frame.dropped} messages came too fast`);
  byId("bad").hidden = !bad.length;
  write(byId("bad"), bad.join(" · "));
}
