// The latest samples of all channels on one line of time: a ring that forgets the oldest.

export class Store {
  constructor(channels, capacity = 1 << 20) {
    this.channels = channels; // [{name, unit}]
    this.capacity = capacity; // a power of two
    this.times = new Float64Array(capacity);
    this.columns = channels.map(() => new Float64Array(capacity));
    this.end = 0; // samples put in so far; sample i lies at i modulo capacity
    this.received = 0; // of them, without the marks of gaps
    this.missing = 0; // samples of a run that never came
    this.period = 0;
    this.run = 0;
  }

  get first() { return Math.max(0, this.end - this.capacity); }
  get newest() { return this.end ? this.time(this.end - 1) : 0; }
  get oldest() { return this.end ? this.time(this.first) : 0; }
  time(i) { return this.times[i & (this.capacity - 1)]; }
  value(channel, i) { return this.columns[channel][i & (this.capacity - 1)]; }

  // One frame: samples from `start` on, `period` apart, of one run. What lies before is left out.
  append(run, start, period, columns) {
    if (this.end && start <= this.newest) return;
    if (this.end) {
      const gap = Math.round((start - this.newest) / period) - 1;
      if (gap > 0 || run !== this.run) this.#put(start - period / 2, columns.map(() => [NaN]), 0, 0);
      if (gap > 0 && run === this.run) this.missing += gap;
    }
    this.run = run;
    this.period = period;
    const count = columns[0].length;
    for (let k = 0; k < count; k++) this.#put(start, columns, k, k * period);
    this.received += count;
  }

  #put(start, columns, k, after) {
    const at = this.end & (this.capacity - 1);
    this.times[at] = start + after;
    for (let c = 0; c < columns.length; c++) this.columns[c][at] = columns[c][k];
    this.end++;
  }

  // The first sample at or after `time`; `end` where there is none.
  find(time) {
    let low = this.first, high = this.end;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.time(middle) < time) low = middle + 1; else high = middle;
    }
    return low;
  }

  // Each channel from `from` to `to` as points to draw: all of them, or the least and the greatest
  // of each of about `width` bins. Bins begin at multiples of their size, so that they stand still.
  envelope(from, to, width) {
    const begin = Math.max(this.first, this.find(from) - 1);
    const end = Math.min(this.end, this.find(to) + 1);
    const size = Math.floor((end - begin) / width);
    return size > 2 ? this.#bins(begin, end, size) : this.#all(begin, end);
  }

  #all(begin, end) {
    const xs = [], ys = this.columns.map(() => []);
    for (let i = begin; i < end; i++) {
      xs.push(this.time(i));
      for (let c = 0; c < ys.length; c++) {
        const value = this.value(c, i);
        ys[c].push(value === value ? value : null);
      }
    }
    return { xs, ys };
  }

  #bins(begin, end, size) {
    const xs = [], ys = this.columns.map(() => []);
    for (let bin = begin; bin < end;) {
      const next = Math.min(end, (Math.floor(bin / size) + 1) * size);
      xs.push(this.time(bin), this.time((bin + next) >> 1));
      for (let c = 0; c < ys.length; c++) {
        let low = Infinity, high = -Infinity, gap = false;
        for (let i = bin; i < next; i++) {
          const value = this.value(c, i);
          if (value < low) low = value;
          if (value > high) high = value;
          gap ||= value !== value;
        }
        const none = low > high;
        ys[c].push(none ? null : low, none || gap ? null : high);
      }
      bin = next;
    }
    return { xs, ys };
  }

  // Mean, root mean square, least and greatest of a channel between two times; null where empty.
  summary(channel, from, to) {
    let count = 0, sum = 0, squares = 0, low = Infinity, high = -Infinity;
    for (let i = this.find(from); i < this.end && this.time(i) <= to; i++) {
      const value = this.value(channel, i);
      if (value !== value) continue;
      count++; sum += value; squares += value * value;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return count ? { mean: sum / count, rms: Math.sqrt(squares / count), low, high } : null;
  }

  // The value of the sample nearest to a time; NaN where there is none.
  at(channel, time) {
    if (!this.end) return NaN;
    const after = Math.min(this.find(time), this.end - 1);
    const before = Math.max(after - 1, this.first);
    const near = time - this.time(before) < this.time(after) - time ? before : after;
    return Math.abs(this.time(near) - time) <= 2 * this.period ? this.value(channel, near) : NaN;
  }
}
