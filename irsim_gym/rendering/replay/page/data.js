"use strict";
// The recording. irsim_gym/render/packing.py packs the numbers that become tables here.

async function readRecording(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).json();
}

/** Numbers by moment and column; one row stands for any number of equal ones. */
class Table {
  constructor({ unit, width, values }) {
    this.width = width;
    this.isStill = values.length === width;
    this.numbers = new Float64Array(values.length);
    const latest = new Array(width).fill(0);
    values.forEach((value, i) => {
      const column = i % width;
      if (value !== null) latest[column] += value;
      this.numbers[i] = value === null ? NaN : latest[column] * unit;
    });
  }

  at(moment, column = 0) {
    return this.numbers[(this.isStill ? 0 : moment * this.width) + column];
  }

  row(moment) {
    const first = this.isStill ? 0 : moment * this.width;
    return this.numbers.subarray(first, first + this.width);
  }

  get count() {
    return this.numbers.length / this.width;
  }

  rows() {
    return Array.from({ length: this.count }, (_, i) => this.row(i));
  }
}

/** Return the value at a moment, from a list of changes. */
function valueAt(changes, moment) {
  let low = 0;
  let high = changes.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (changes[middle][0] <= moment) low = middle + 1;
    else high = middle;
  }
  return low ? changes[low - 1][1] : null;
}

/** An outline in a frame of its own. */
class Shape {
  constructor({ chains = [], offsets = [], least = 0, discs, sector, dot = 0, boxes, cell }) {
    const rows = (packed) => (packed ? new Table(packed).rows() : []);
    Object.assign(this, { chains: chains.map(rows), offsets: offsets.map(rows), least, discs: rows(discs), sector, dot });
    Object.assign(this, { boxes: rows(boxes), cell });
  }

  /** Return it in metres, where a point of type has this size; most are made once. */
  path(point) {
    if (!this.known || (this.point !== point && (this.offsets.length || this.dot))) {
      this.known = this.make(point);
      this.point = point;
    }
    return this.known;
  }

  make(point) {
    const path = new Path2D();
    for (const line of this.lines(point)) {
      line.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
      const [first, last] = [line[0], line[line.length - 1]];
      if (line.length > 2 && first[0] === last[0] && first[1] === last[1]) path.closePath();
    }
    for (const [x, y, radius] of this.dot ? [[0, 0, this.dot * point]] : this.discs) {
      path.moveTo(x + radius, y);
      path.arc(x, y, radius, 0, 2 * Math.PI);
    }
    if (this.sector) {
      const [span, radius] = this.sector;
      if (span < 2 * Math.PI - 0.01) path.moveTo(0, 0);
      path.arc(0, 0, radius, -span / 2, span / 2);
      path.closePath();
    }
    const [x, y, wide, high] = this.cell ?? [];
    for (const [first, low, end, above] of this.boxes) {
      path.rect(x + first * wide, y + low * high, (end - first) * wide, (above - low) * high);
    }
    return path;
  }

  /** Return its chains, with their offsets added. */
  lines(point) {
    if (!this.offsets.length) return this.chains;
    return this.offsets.map((offsets, k) => offsets.map(([a, b], i) => {
      const [x, y] = this.chains[k]?.[i] ?? [0, 0];
      const away = Math.hypot(x, y) || 1;
      const size = Math.max(this.least * point, away) / away;
      return [x * size + a * point, y * size + b * point];
    }));
  }
}

/** A body: its outline, and where it is. */
class Body {
  constructor(data, shapes) {
    Object.assign(this, { ...data, shape: shapes[data.shape] });
    [this.place, this.heading] = data.poses.map((table) => new Table(table));
  }

  isThere(moment) {
    return !Number.isNaN(this.place.at(moment));
  }

  /** Return x, y and heading; ``turned`` for that of the mark of its heading. */
  poseAt(moment, turned = false) {
    return [...this.place.row(moment), this.heading.at(moment) + (turned ? this.heading.at(moment, 1) : 0)];
  }

  /** Return the box around it: x_min, y_min, x_max, y_max. */
  boxAt(moment) {
    const [x, y, heading] = this.poseAt(moment);
    const [cosine, sine] = [Math.cos(heading), Math.sin(heading)];
    const placed = [...this.shape.chains.flat(), ...this.shape.discs].map(([a, b, radius = 0]) => (
      [x + cosine * a - sine * b, y + sine * a + cosine * b, radius]));
    if (!placed.length) return [x, y, x, y];
    const most = (axis, sign) => sign * Math.max(...placed.map((corner) => sign * corner[axis] + corner[2]));
    return [most(0, -1), most(1, -1), most(0, 1), most(1, 1)];
  }
}

/** What a range sensor sees. */
class Scan {
  constructor(data) {
    const [place, heading] = data.places.map((table) => new Table(table));
    Object.assign(this, { ...data, place, heading, ranges: new Table(data.ranges) });
    this.speeds = data.speeds && new Table(data.speeds);
  }

  isThere(moment) {
    return !Number.isNaN(this.place.at(moment));
  }

  /** Return where the sensor is, and the ends and radial velocities of its beams: all, hits, valid or free ones. */
  at(moment, which) {
    const [[x, y], heading] = [this.place.row(moment), this.heading.at(moment)];
    const chosen = {
      all: () => true,
      hits: (range) => range < (this.far ?? Infinity),
      valid: (range) => chosen.hits(range) && range > this.near,
      free: (range) => !chosen.valid(range),
    };
    const ends = [];
    this.angles.forEach((angle, i) => {
      const range = this.ranges.at(moment, i);
      if (!chosen[which](range)) return;
      ends.push([x + range * Math.cos(heading + angle), y + range * Math.sin(heading + angle), this.speeds?.at(moment, i) ?? 0]);
    });
    return { x, y, ends };
  }
}

/** One episode, ready to be drawn. */
class Episode {
  constructor(data, { pens, shapes, pictures, theme }) {
    Object.assign(this, data);
    this.time = new Table(data.time);
    this.center = data.center && new Table(data.center);
    this.bodies = data.bodies.map((body) => new Body(body, shapes));
    this.fog = data.fog && new Fog(data.fog);
    this.scans = data.scans.map((scan) => new Scan(scan));
    this.items = data.items.map((item) => ({
      ...theme.defaults[item.draw],
      ...item,
      body: this.bodies[item.body],
      scan: this.scans[item.scan],
      pen: pens[item.pen],
      shape: shapes[item.shape],
      picture: pictures[item.pixels],
      places: item.places && new Table(item.places).rows(),
    }));
    this.agents = data.agents.map((agent) => ({
      ...agent,
      values: tables(agent.values),
      terms: tables(agent.terms),
      action: agent.action && new Table(agent.action),
    }));
  }

  /** Return the items that are seen at a moment, the lowest first. */
  itemsAt(moment) {
    const isWithin = (spans) => spans.some((first, i) => i % 2 === 0 && first <= moment && moment < spans[i + 1]);
    return this.items.filter(({ spans, body, scan }) => (
      (!spans || isWithin(spans)) && (!body || body.isThere(moment)) && (!scan || scan.isThere(moment))));
  }

  /** Return the latest moment that is not after a time. */
  momentAt(time) {
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time.at(middle) <= time + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  get duration() {
    return this.time.at(this.count - 1);
  }

  body(name, moment) {
    return this.bodies.find((body) => body.name === name && body.isThere(moment));
  }
}

/** The cells that no robot has seen at a moment. */
class Fog {
  constructor(data) {
    Object.assign(this, data);
    this.canvas = Object.assign(document.createElement("canvas"), { width: data.size[0], height: data.size[1] });
    this.rewind();
  }

  rewind() {
    this.covered = new Uint8Array(this.size[0] * this.size[1]);
    this.done = 0;
  }

  /** Return which cells are covered. */
  at(moment) {
    if (this.done && this.changes[this.done - 1][0] > moment) this.rewind();
    for (; this.done < this.changes.length && this.changes[this.done][0] <= moment; this.done++) {
      let cell = 0;
      for (const step of this.changes[this.done][1]) this.covered[(cell += step)] ^= 1;
    }
    return this.covered;
  }

  /** Return a picture of them, one pixel for each, with soft borders as those of frames. */
  cover(moment, [red, green, blue, opacity]) {
    const [columns, rows] = this.size;
    const covered = this.at(moment);
    const within = (i, most) => Math.min(Math.max(i, 0), most - 1);
    const isCovered = (i, j) => covered[within(i, columns) * rows + within(j, rows)];
    const pixels = new ImageData(columns, rows);
    for (let i = 0; i < columns; i++) {
      for (let j = 0; j < rows; j++) {
        if (!isCovered(i, j)) continue;
        let around = 0;
        for (let k = 0; k < 9; k++) around += isCovered(i + (k % 3) - 1, j + Math.floor(k / 3) - 1);
        pixels.data.set([red, green, blue, opacity * (0.5 + around / 18)], 4 * ((rows - 1 - j) * columns + i));
      }
    }
    this.canvas.getContext("2d").putImageData(pixels, 0, 0);
    return this.canvas;
  }
}

function tables(packed) {
  return Object.fromEntries(Object.entries(packed).map(([name, values]) => [name, new Table(values)]));
}
