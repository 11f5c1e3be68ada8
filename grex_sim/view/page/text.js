// Numbers and times as text; what is no number is a dash.

/** A number with so many decimals. */
export function number(value, decimals = 1) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Mission time as minutes and seconds, or hours. */
export function time(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const whole = Math.floor(Math.max(seconds, 0));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (value) => String(value).padStart(2, "0");
  return h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** What became of a message, for people: lost_burst is "burst". */
export function cause(reason) {
  const [kind, ...rest] = reason.split("_");
  return (["lost", "missed"].includes(kind) && rest.length ? rest : [kind, ...rest]).join(" ") || "lost";
}

/** Write only what is different: nothing is laid out anew in vain. */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
