// The past of a run, column by column, for charts and trails: as long as it may be drawn, then every second point goes.

const MOST = 2400;

export class Past {
  constructor({ names, columns }) {
    this.names = names;
    this.columns = columns.length > 1 ? columns : [[], ...names.map(() => [])];
    this.apart = 0;
    this.version = 0;
  }

  add(t, row) {
    const times = this.columns[0];
    if (times.length && t < times.at(-1) + Math.max(this.apart, 1e-9)) return;
    [t, ...row].forEach((value, place) => this.columns[place].push(value));
    if (times.length > MOST) {
      this.columns = this.columns.map((column) => column.filter((_, place) => place % 2 === 0));
      const thinned = this.columns[0];
      this.apart = 0.999 * (thinned.at(-1) - thinned[0]) / (thinned.length - 1);
    }
    this.version += 1;
  }

  column(name) {
    return this.columns[this.names.indexOf(name) + 1] ?? [];
  }

  /** How many points there are up to a time. */
  until(seconds) {
    const times = this.columns[0];
    let [low, high] = [0, times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= seconds) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
