// One look for each craft, everywhere: a colour of Okabe and Ito's, a dash where colours run out, and its number.

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", null];
const DASHES = [[], [6, 3], [2, 3], [8, 3, 2, 3], [12, 4]];
const NAMES = ["--ink", "--soft", "--line", "--faint", "--sea", "--panel", "--blue", "--red", "--green"];

export const theme = {};

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) theme[name.slice(2)] = style.getPropertyValue(name).trim();
}
readTheme();

/** Calls back when the user's light or dark scheme changes. */
export function onTheme(callback) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readTheme();
    callback();
  });
}

/** Colour of the craft at a place in the team; beyond six it is ink. */
export function colour(place) {
  return COLOURS[place % COLOURS.length] ?? theme.ink;
}

/** Dash of its lines. */
export function dash(place) {
  return DASHES[Math.floor(place / COLOURS.length) % DASHES.length];
}
