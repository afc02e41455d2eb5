"use strict";
// What was recorded. Packed numbers become tables; irsim_gym/render/packing.py says how they are packed.

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
}

/** Return what a list of changes says at a moment. */
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

/** One episode, ready to be drawn. */
class Episode {
  constructor(data, { maps, pictures }) {
    Object.assign(this, data);
    this.time = new Table(data.time);
    this.center = data.center && new Table(data.center);
    this.maps = data.maps.map(([moment, map]) => [moment, map === null ? null : maps[map]]);
    this.bodies = data.bodies.map((body) => ({
      ...body,
      ...posesOf(body),
      style: data.styles[body.style],
      image: body.image && { ...body.image, picture: pictures[body.image.picture] },
    }));
    this.fog = data.fog && new Fog(data.fog);
    this.scans = data.scans.map((scan) => ({
      ...scan,
      style: data.styles[scan.style],
      ranges: new Table(scan.ranges),
      speeds: scan.speeds && new Table(scan.speeds),
      place: new Table(scan.places[0]),
      heading: new Table(scan.places[1]),
    }));
    this.marks = data.marks.map((mark) => ({ ...mark, points: new Table(mark.points) }));
    this.goals = data.goals.map(([moment, goals]) => [
      moment, goals.map((goal) => ({ ...goal, style: data.styles[goal.style] })),
    ]);
    this.agents = data.agents.map((agent) => ({
      ...agent,
      values: tables(agent.values),
      terms: tables(agent.terms),
      action: agent.action && new Table(agent.action),
    }));
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
    return this.bodies.find((body) => body.name === name && !Number.isNaN(body.place.at(moment, 0)));
  }
}

/** The cells that nobody has seen at a moment. */
class Fog {
  constructor(data) {
    Object.assign(this, data);
    this.rewind();
  }

  rewind() {
    this.covered = new Uint8Array(this.size[0] * this.size[1]);
    this.done = 0;
  }

  /** Return which cells are covered, and the number of changes up to then. */
  at(moment) {
    if (this.done && this.changes[this.done - 1][0] > moment) this.rewind();
    for (; this.done < this.changes.length && this.changes[this.done][0] <= moment; this.done++) {
      let cell = 0;
      for (const step of this.changes[this.done][1]) this.covered[(cell += step)] ^= 1;
    }
    return this.covered;
  }
}

function posesOf(body) {
  return { place: new Table(body.poses[0]), heading: new Table(body.poses[1]), isFixed: body.fixed };
}

function tables(packed) {
  return Object.fromEntries(Object.entries(packed).map(([name, values]) => [name, new Table(values)]));
}
