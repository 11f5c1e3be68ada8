// The tables: every craft in figures, and the health of every process.

import { colour } from "./colours.js";
import { number, write } from "./text.js";

const WORDS = {
  alive: "alive", lost: "lost", ended: "ended", missing: "not there", unseen: "out of sight", recorded: "recorded",
};
const SLOW = 0.8;

/** Rows are kept and written over, so that nothing jumps and a screen reader keeps its place. */
function rowOf(body, name, cells, place) {
  let row = [...body.rows].find((entry) => entry.dataset.name === name);
  if (!row) {
    row = body.insertRow();
    row.dataset.name = name;
    const head = document.createElement("th");
    head.scope = "row";
    if (place >= 0) head.append(swatch(place));
    head.append(name);
    row.append(head);
    for (let count = 0; count < cells; count += 1) row.insertCell();
  }
  return row;
}

function swatch(place) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 12 12");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", "M6 0 11 12 6 9 1 12Z");
  path.setAttribute("fill", colour(place));
  svg.append(path);
  return svg;
}

export function clearTables() {
  for (const id of ["craft", "health"]) document.getElementById(id).tBodies[0].replaceChildren();
}

export function showCraft(frame, names) {
  const body = document.getElementById("craft").tBodies[0];
  names.forEach((name, place) => {
    const shown = frame.craft[name] ?? {};
    const row = rowOf(body, name, 8, place);
    const ages = Object.values(shown.mates ?? {}).map((belief) => belief[4]).filter((age) => age !== null && age >= 0);
    const pose = shown.true ?? [];
    const texts = [
      number(pose[0]), number(pose[1]), number(pose[2]), String(shown.track ?? "–"), number(shown.theta, 3),
      number(shown.xte, 2), number(shown.ordered, 2), ages.length ? number(Math.max(...ages), 0) : "–",
    ];
    texts.forEach((text, cell) => write(row.cells[cell + 1], text));
  });
}

export function showHealth(rows) {
  const body = document.getElementById("health").tBodies[0];
  for (const { who, role, state, silent_s: silent, rates, notes } of rows) {
    const row = rowOf(body, role === who ? who : `${role} ${who.replace(/^(modem|frontseat)_/, "")}`, 4, -1);
    let badge = row.cells[1].firstElementChild;
    if (!badge) {
      badge = document.createElement("span");
      badge.className = "state";
      row.cells[1].append(badge);
    }
    badge.dataset.state = state;
    write(badge, WORDS[state] ?? state);
    write(row.cells[2], silent === null ? "" : `${number(silent, silent < 10 ? 1 : 0)} s`);
    showRates(row.cells[3], rates, state);
    const said = Object.entries(notes).map(([name, value]) => `${name} ${value}`).join(" · ");
    write(row.cells[4], said);
    row.cells[4].classList.toggle("ill", "health" in notes || notes["late ticks"] > 0);
  }
}

function showRates(cell, rates, state) {
  const said = JSON.stringify([rates, state === "alive"]);
  if (cell.dataset.said === said) return;
  cell.dataset.said = said;
  cell.replaceChildren(...Object.entries(rates).map(([name, [hz, wanted]]) => {
    const span = document.createElement("span");
    span.className = "rate";
    const slow = wanted !== null && hz < SLOW * wanted;
    if (slow && state === "alive") span.classList.add("slow");
    const figures = Object.assign(document.createElement("span"), { textContent: ` ${number(hz)}` });
    const want = Object.assign(document.createElement("i"), { textContent: wanted === null ? "" : ` (${number(wanted)})` });
    span.append(name.replace("_", " "), figures, want);
    return span;
  }));
}
