// Draws one moment of an episode as the frames of irsim_gym show it.

const FONT = '"DejaVu Sans", Verdana, system-ui, sans-serif';

class WorldView {
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.theme = theme;
    this.whole();
  }

  /** Show another episode; the view stays where it is if both worlds have the same bounds. */
  show(episode) {
    if (!this.episode || String(this.episode.bounds) !== String(episode.bounds)) this.whole();
    this.episode = episode;
  }

  whole() {
    this.look = { zoom: 1, x: null, y: null };
  }

  /** Fit the canvas to its place on the page, and the world to the canvas. */
  layOut(center) {
    const { canvas, episode, look, theme: { margins } } = this;
    const { axis, title } = episode.look;
    this.ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const [columns, rows] = [Math.round(width * this.ratio), Math.round(height * this.ratio)];
    if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
    this.large = Math.min(Math.max(Math.sqrt(width * height) / 600, 0.75), 2);
    this.point = (100 / 72) * this.large;
    const margin = (side, shown) => this.large * (shown ? margins[side] : margins.bare);
    const [left, right] = [margin("left", axis), margin("right", axis)];
    const [top, bottom] = [margin("top", title), margin("bottom", axis)];
    const room = [Math.max(width - left - right, 16), Math.max(height - top - bottom, 16)];
    const [xMin, yMin, xMax, yMax] = episode.bounds;
    const padding = 2 * margins.padding * this.large;
    const fit = Math.min((room[0] - padding) / (xMax - xMin), (room[1] - padding) / (yMax - yMin));
    const plot = look.zoom === 1 && look.x === null && !center
      ? [(xMax - xMin) * fit + padding, (yMax - yMin) * fit + padding] : room;
    const [x, y] = center ?? [look.x ?? (xMin + xMax) / 2, look.y ?? (yMin + yMax) / 2];
    this.scale = fit * look.zoom;
    this.plot = { left: left + (room[0] - plot[0]) / 2, top: top + (room[1] - plot[1]) / 2, width: plot[0], height: plot[1] };
    const half = [plot[0] / this.scale / 2, plot[1] / this.scale / 2];
    this.limits = [x - half[0], y - half[1], x + half[0], y + half[1]];
    this.size = [width, height];
    canvas.style.touchAction = look.x === null ? "pan-y" : "none";  // the whole world lets a finger scroll the page
  }

  column(x) {
    return this.plot.left + (x - this.limits[0]) * this.scale;
  }

  row(y) {
    return this.plot.top + (this.limits[3] - y) * this.scale;
  }

  /** Return the point of the world at a pixel of the canvas. */
  pointAt(column, row) {
    return [(column - this.plot.left) / this.scale + this.limits[0], this.limits[3] - (row - this.plot.top) / this.scale];
  }

  /** Zoom by a factor; the point at a pixel stays where it is. */
  zoomAt(factor, column = this.size[0] / 2, row = this.size[1] / 2) {
    const zoom = Math.min(Math.max(this.look.zoom * factor, 1), 60);
    const [x, y] = this.pointAt(column, row);
    const [left, bottom, right, top] = this.limits;
    const share = this.look.zoom / zoom;
    if (zoom === 1) this.whole();
    else this.look = { zoom, x: x + ((left + right) / 2 - x) * share, y: y + ((bottom + top) / 2 - y) * share };
  }

  /** Move the view by this many pixels. */
  pan(columns, rows) {
    const [left, bottom, right, top] = this.limits;
    this.look.x = (left + right) / 2 - columns / this.scale;
    this.look.y = (bottom + top) / 2 + rows / this.scale;
  }

  /** Draw a moment; the options choose scans, paths and names, and the robot that the view follows. */
  draw(moment, options) {
    const { episode, context } = this;
    const followed = options.follow && episode.body(options.follow, moment);
    const fixed = episode.center && !Number.isNaN(episode.center.at(moment)) ? [...episode.center.row(moment)] : null;
    const isFree = this.look.x !== null;
    this.layOut(followed ? [followed.place.at(moment, 0), followed.place.at(moment, 1)] : isFree ? null : fixed);
    const style = getComputedStyle(document.documentElement);
    this.page = (name) => style.getPropertyValue(`--${name}`).trim();
    this.pixels();
    context.fillStyle = this.page("paper");
    context.fillRect(0, 0, ...this.size);
    this.drawCard();
    context.save();
    this.cutToPlot();
    this.items = episode.itemsAt(moment);
    this.drawItems(moment, options);
    context.restore();
    this.pixels();
    if (episode.look.title) this.drawHead(moment);
  }

  /** Draw the items of the moment, the lowest first; the rank of each says how it is cut at the world's border. */
  drawItems(moment, options) {
    const { context, items, theme: { ranks } } = this;
    let cut = null;
    context.save();
    for (const item of items) {
      const { reach, switch: name } = ranks[item.rank];
      if (name && !options[name]) continue;
      const wanted = this.episode.center ? null : reach;
      if (wanted !== cut) {
        context.restore();
        context.save();
        if (wanted !== null) this.cutToWorld(wanted);
        cut = wanted;
      }
      PRIMITIVES[item.draw](this, item, moment);
    }
    context.restore();
  }

  pixels() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
  }

  /** Use metres in the frame of a body, or of the world. */
  metres(x = 0, y = 0, heading = 0) {
    const size = this.ratio * this.scale;
    this.context.setTransform(size, 0, 0, -size, this.ratio * this.column(0), this.ratio * this.row(0));
    this.context.translate(x, y);
    if (heading) this.context.rotate(heading);
  }

  /** Use a pen, while lengths are metres. */
  take({ fill, edge, width, line, in_metres, cap }) {
    const { context, theme } = this;
    const point = this.point / this.scale;
    const wide = in_metres ? Math.max(width, theme.thinnest * point) : width * point;
    Object.assign(context, { fillStyle: fill, strokeStyle: edge, lineWidth: wide, lineCap: cap, lineJoin: "round" });
    context.setLineDash(theme.dashes[line].map((dash) => dash * wide));
  }

  cutToPlot() {
    const { left, top, width, height } = this.plot;
    this.context.beginPath();
    this.context.rect(left, top, width, height);
    this.context.clip();
  }

  cutToWorld(points) {
    const [left, top, width, height] = this.card();
    const wider = points * this.point;
    this.pixels();
    this.context.beginPath();
    this.context.rect(left - wider, top - wider, width + 2 * wider, height + 2 * wider);
    this.context.clip();
  }

  /** Return the world's rectangle in pixels. */
  card() {
    const [xMin, yMin, xMax, yMax] = this.episode.bounds;
    return [this.column(xMin), this.row(yMax), (xMax - xMin) * this.scale, (yMax - yMin) * this.scale];
  }

  drawCard() {
    const { context, episode, theme, limits, plot } = this;
    const [xMin, yMin, xMax, yMax] = episode.bounds;
    const low = [Math.max(xMin, limits[0]), Math.max(yMin, limits[1])];
    const high = [Math.min(xMax, limits[2]), Math.min(yMax, limits[3])];
    context.save();
    this.cutToPlot();
    context.fillStyle = theme.card;
    context.fillRect(...this.card());
    context.restore();
    if (!episode.look.axis || low[0] > high[0] || low[1] > high[1]) return;
    const [columns, rows] = [ticks(low[0], high[0], plot.width / this.large), ticks(low[1], high[1], plot.height / this.large)];
    context.strokeStyle = theme.grid;
    context.lineWidth = 0.7 * this.point;
    context.beginPath();
    for (const x of columns) context.moveTo(this.column(x), this.row(low[1])), context.lineTo(this.column(x), this.row(high[1]));
    for (const y of rows) context.moveTo(this.column(low[0]), this.row(y)), context.lineTo(this.column(high[0]), this.row(y));
    context.stroke();
    context.save();
    this.cutToPlot();
    context.strokeStyle = theme.rule;
    context.lineWidth = 0.8 * this.point;
    context.strokeRect(...this.card());
    context.restore();
    context.fillStyle = this.page("faint");
    context.font = `${7.5 * this.point}px ${FONT}`;
    const gap = 6 * this.large;
    Object.assign(context, { textAlign: "center", textBaseline: "top" });
    for (const x of columns) {
      context.fillText(short(x) + (x === columns[columns.length - 1] ? " m" : ""), this.column(x), this.row(low[1]) + gap);
    }
    Object.assign(context, { textAlign: "right", textBaseline: "middle" });
    for (const y of rows) context.fillText(short(y), this.column(low[0]) - gap, this.row(y));
  }

  drawHead(moment) {
    const { context, episode, plot, point } = this;
    const status = valueAt(episode.status, moment);
    const y = plot.top - 21 * this.large;
    context.textBaseline = "middle";
    context.fillStyle = this.page("ink");
    const title = valueAt(episode.titles, moment) ?? (episode.look.titled ? episode.title : null);
    if (title !== null) {
      context.textAlign = "center";
      context.font = `bold ${9.5 * point}px ${FONT}`;
      context.fillText(title, plot.left + plot.width / 2, y, this.size[0] - 20);
      return;
    }
    const [left, right] = plot.width > 300 ? [plot.left, plot.left + plot.width] : [10, this.size[0] - 10];
    context.textAlign = "right";
    context.font = `${9 * point}px ${FONT}`;
    const room = 66 * this.large;
    context.fillText(`${episode.time.at(moment).toFixed(1)} s`, right, y);
    const words = `\u25cf ${status.replaceAll("_", " ")}`;
    context.fillStyle = episode.tones[status];
    context.fillText(words, right - room, y);
    const longest = Math.max(...["\u25cf left world", words].map((text) => context.measureText(text).width));
    const rest = right - left - room - longest - 14;
    context.textAlign = "left";
    context.fillStyle = this.page("ink");
    context.font = `bold ${9.5 * point}px ${FONT}`;
    if (rest > 40) context.fillText(cutTo(context, episode.title, rest), left, y);
  }
}

/** Cut words to a room in pixels. */
function cutTo(context, words, room) {
  let shown = words;
  while (shown && context.measureText(shown).width > room) shown = `${shown.replace("\u2026", "").slice(0, -1)}\u2026`.replace(/^\u2026$/, "");
  return shown;
}

/** Return round numbers from low to high, at most one per 70 of ``room`` pixels. */
function ticks(low, high, room) {
  const wanted = (high - low) / Math.max(Math.min(room / 70, 12), 1);
  const magnitude = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((factor) => factor * magnitude).find((size) => size >= wanted * (1 - 1e-9));
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i <= Math.floor(high / step + 1e-9); i++) found.push(i * step);
  return found;
}

/** Return a number as short as it is round. */
function short(value) {
  return String(Number(value.toFixed(9))).replace("-", "\u2212");
}
