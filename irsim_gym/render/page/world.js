// Draws one moment of an episode as the frames of irsim_gym show it.

const MARGINS = { left: 42, right: 34, top: 42, bottom: 34, bare: 12, padding: 9 };
const FONT = '"DejaVu Sans", Verdana, system-ui, sans-serif';
const [GROUND, TOP] = [1, 1e9];
const [FADE_STEPS, FAINTEST, MOST_BEAMS] = [28, 0.12, 100];
const [FLAG_WIDTH, FLAG_HEIGHT] = [6.5, 10.5];

/** Ranks of what is cut at the world's borders, and how far it may reach over them: half the width of a wall [point]. */
const REACH = { 0: 1.1, 2: 0, 3: 0, 4: 0, 6: 0, 7: 1.1, 8: 1.1, 9: 0, 10: 1.1, 12: 0 };

class WorldView {
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.theme = theme;
    this.look = { zoom: 1, x: null, y: null };
    this.paths = new Map();
  }

  /** Show another episode; the part of the world that is seen stays where both are of one size. */
  show(episode) {
    if (!this.episode || String(this.episode.bounds) !== String(episode.bounds)) this.whole();
    this.episode = episode;
    this.paths.clear();
  }

  whole() {
    this.look = { zoom: 1, x: null, y: null };
  }

  /** Fit the canvas to its place on the page, and lay the world out on it. */
  layOut(center) {
    const { canvas, episode, look } = this;
    const { axis, title } = episode.look;
    this.ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const [columns, rows] = [Math.round(width * this.ratio), Math.round(height * this.ratio)];
    if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
    this.large = Math.min(Math.max(Math.sqrt(width * height) / 600, 0.75), 2);
    this.point = (100 / 72) * this.large;
    const margin = (side, shown) => this.large * (shown ? MARGINS[side] : MARGINS.bare);
    const [left, right] = [margin("left", axis), margin("right", axis)];
    const [top, bottom] = [margin("top", title), margin("bottom", axis)];
    const room = [Math.max(width - left - right, 16), Math.max(height - top - bottom, 16)];
    const [xMin, yMin, xMax, yMax] = episode.bounds;
    const padding = 2 * MARGINS.padding * this.large;
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

  /** Move what is seen by so many pixels. */
  pan(columns, rows) {
    const [left, bottom, right, top] = this.limits;
    this.look.x = (left + right) / 2 - columns / this.scale;
    this.look.y = (bottom + top) / 2 + rows / this.scale;
  }

  /** Draw a moment; the options say which of scans, paths and names are shown, and whom the picture follows. */
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
    this.drawMap(valueAt(episode.maps, moment));
    const status = valueAt(episode.status, moment) ?? "";
    const outcome = this.theme.outcomes[status.trim().toLowerCase().replaceAll(" ", "_")];
    if (outcome) this.frame(tinted(outcome, 0.07), null);
    for (const [, rank, draw] of this.layers(moment, options)) {
      context.save();
      if (!episode.center && rank in REACH) this.cutToWorld(REACH[rank]);
      draw();
      context.restore();
    }
    if (outcome) this.frame(null, tinted(outcome, 0.9));
    context.restore();
    this.pixels();
    if (episode.look.title) this.drawHead(moment, status, outcome ?? this.theme.running);
  }

  pixels() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
  }

  /** Go on in metres, in the frame of a body or of the world. */
  metres(x = 0, y = 0, heading = 0) {
    const size = this.ratio * this.scale;
    this.context.setTransform(size, 0, 0, -size, this.ratio * this.column(0), this.ratio * this.row(0));
    this.context.translate(x, y);
    if (heading) this.context.rotate(heading);
  }

  /** Set the width of lines in points, while lengths are metres. */
  line(points, style = "solid") {
    const width = (points * this.point) / this.scale;
    this.context.lineWidth = width;
    this.context.setLineDash(dashes(style).map((dash) => dash * width));
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

  drawMap(map) {
    if (!map) return;
    if (!this.paths.has(map)) {
      const path = new Path2D();
      const [x, y, right, top] = map.extent;
      const [wide, high] = [(right - x) / map.size[0], (top - y) / map.size[1]];
      for (let i = 0; i < map.boxes.length; i += 4) {
        const [first, low, end, above] = map.boxes.slice(i, i + 4);
        path.rect(x + first * wide, y + low * high, (end - first) * wide, (above - low) * high);
      }
      this.paths.set(map, path);
    }
    this.metres();
    this.line(0.5);  // thin walls are seen however small the map is, and boxes have no seams
    this.context.globalAlpha = map.alpha;
    this.context.fillStyle = this.context.strokeStyle = map.colour;
    this.context.fill(this.paths.get(map));
    this.context.stroke(this.paths.get(map));
    this.context.globalAlpha = 1;
  }

  frame(fill, edge) {
    this.pixels();
    this.context.setLineDash([]);
    if (fill) {
      this.context.fillStyle = fill;
      this.context.fillRect(...this.card());
    } else {
      this.context.strokeStyle = edge;
      this.context.lineWidth = 2.2 * this.point;
      this.context.strokeRect(...this.card());
    }
  }

  /** Return what lies on the ground, the lowest first: layer, rank within it, how it is drawn. */
  layers(moment, options) {
    const { episode } = this;
    const items = episode.fog ? [[GROUND, 1, () => drawFog(this, moment)]] : [];
    const there = episode.bodies.filter((body) => !Number.isNaN(body.place.at(moment, 0)));
    for (const body of there) {
      const { style } = body;
      items.push([style.order, body.isFixed ? 0 : 7, () => drawBody(this, body, moment)]);
      if (body.mark.length) items.push([style.arrow_order ?? style.order, 8, () => drawMark(this, body, moment)]);
      if (body.field) items.push([style.field_order, 3, () => drawField(this, body, moment)]);
      if (!options.paths || body.isFixed) continue;
      if (body.ghost) items.push([style.ghost.order, 4, () => drawGhosts(this, body, moment)]);
      if (style.show_trajectory) items.push([style.trajectory_order, 6, () => drawPath(this, body, moment)]);
    }
    const goals = valueAt(episode.goals, moment) ?? [];
    for (const goal of goals) items.push([goal.style.goal_order, 5, () => drawGoal(this, goal)]);
    if (options.scans) {
      for (const scan of episode.scans.filter((scan) => !Number.isNaN(scan.place.at(moment, 0)))) {
        items.push([GROUND, 2, () => drawScan(this, scan, moment)], [TOP, 9, () => drawHits(this, scan, moment)]);
      }
    }
    const struck = valueAt(episode.struck, moment) ?? [];
    for (const body of there.filter((body) => struck.includes(body.name))) {
      items.push([TOP, 10, () => drawImpact(this, body, moment)]);
    }
    for (const body of there) items.push([body.style.label_order, 11, () => drawLabel(this, body, moment, goals, options)]);
    for (const goal of goals) items.push([goal.style.label_order, 11, () => drawGoalLabel(this, goal)]);
    for (const mark of episode.marks.filter((mark) => isSeen(mark, moment))) {
      items.push([mark.layer, "text" in mark ? 13 : 12, () => drawOver(this, mark)]);
    }
    return items.sort((one, other) => one[0] - other[0] || one[1] - other[1]);
  }

  drawHead(moment, status, colour) {
    const { context, episode, plot, point } = this;
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
    context.fillStyle = tinted(colour, 1);
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
