// The primitives that draw an episode's items; irsim_gym/render/primitives.py documents their fields.

const PRIMITIVES = {
  Figure: drawFigure, Picture: drawPicture, Way: drawWay, Beams: drawBeams, Words: drawWords, Cover: drawCover,
};

/** Return the poses at which an item is drawn, x, y, heading of each: its places or its body's, else the origin. */
function posesOf({ places, body, past, turned }, moment) {
  if (!body) return places ?? [[0, 0]];
  if (!past) return [body.poseAt(moment, turned)];
  const [every, most] = past;
  const moments = [];
  for (let k = 0; k <= moment; k += every) if (body.isThere(k)) moments.push(k);
  return (most ? moments.slice(-most) : moments).map((k) => body.poseAt(k));
}

function drawFigure(view, { shape, pen, shift, ...item }, moment) {
  const { context } = view;
  const point = view.point / view.scale;
  const path = shape.path(point);
  for (const [x, y, heading] of posesOf(item, moment)) {
    view.metres(x + shift * point, y - shift * point, heading);
    view.take(pen);
    if (pen.filled_radius) context.globalAlpha = Math.min(pen.filled_radius * point / shape.discs[0][2], 1) ** 2;
    if (pen.fill) context.fill(path);
    context.globalAlpha = 1;
    if (pen.edge && pen.width) context.stroke(path);
  }
}

function drawPicture(view, { picture, box: [left, bottom, right, top], alpha, body }, moment) {
  const { context } = view;
  if (!picture.complete) return;
  view.metres(...body.poseAt(moment));
  context.translate(left, top);
  context.scale((right - left) / picture.width, (bottom - top) / picture.height);
  context.globalAlpha = alpha;
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0);
  context.globalAlpha = 1;
}

/** Draw where a body has been: a thin line that fades towards its beginning, or a band of one strength. */
function drawWay(view, { body, pen, length }, moment) {
  const { context, theme: { fade } } = view;
  const points = [];
  let [along, bin] = [0, -1];
  for (let k = length ? Math.max(moment + 1 - length, 0) : 0, before = null; k <= moment; k++) {
    if (!body.isThere(k)) continue;
    const [x, y] = [body.place.at(k, 0), body.place.at(k, 1)];
    if (before) along += Math.hypot(x - before[0], y - before[1]) * view.scale;
    if (Math.floor(along / fade.apart) > bin || k === moment) points.push([x, y]);
    bin = Math.floor(along / fade.apart);
    before = [x, y];
  }
  view.metres();
  view.take(pen);
  const parts = pen.in_metres ? 1 : Math.min(fade.steps, points.length - 1);
  let drawn = 0;
  for (let part = 0; part < parts; part++) {
    const [begin, end] = [part, part + 1].map((k) => Math.floor((k * (points.length - 1)) / parts));
    context.globalAlpha = parts === 1 ? 1 : fade.faintest + ((1 - fade.faintest) * part) / (parts - 1);
    context.lineDashOffset = drawn;
    context.beginPath();
    context.moveTo(...points[begin]);
    for (let i = begin; i < end; i++) {
      context.lineTo(...points[i + 1]);
      drawn += Math.hypot(points[i + 1][0] - points[i][0], points[i + 1][1] - points[i][1]);
    }
    context.stroke();
  }
  Object.assign(context, { lineDashOffset: 0, globalAlpha: 1 });
}

/** Draw what a range sensor sees: the area, rays, or dots where these end. */
function drawBeams(view, { scan, form, which, pen, every, radius, speeds }, moment) {
  const { context } = view;
  const { x, y, ends } = scan.at(moment, which);
  const size = radius * view.point / view.scale;
  const paint = () => {
    if (form !== "rays" && pen.fill) context.fill();
    if (form !== "area" && pen.edge && pen.width) context.stroke();
  };
  view.metres();
  view.take(pen);
  context.beginPath();
  if (form === "area" && !scan.surrounds) context.moveTo(x, y);
  ends.forEach(([a, b, speed], i) => {
    if (i % every) return;
    if (speeds) {
      context.beginPath();
      context[form === "rays" ? "strokeStyle" : "fillStyle"] = speedColour(speeds, speed);
    }
    if (form === "dots") context.moveTo(a + size, b), context.arc(a, b, size, 0, 2 * Math.PI);
    if (form === "rays") context.moveTo(x, y);
    if (form !== "dots") context.lineTo(a, b);
    if (speeds) paint();
  });
  if (!speeds) paint();
}

/** Return the colour of a radial velocity: the sign's, mixed with that of rest below the full speed. */
function speedColour({ rest, away, nearer, full_speed }, speed) {
  const share = Math.min(Math.abs(speed) / full_speed, 1);
  const [from, to] = [rest, speed >= 0 ? away : nearer].map(channels);
  const [red, green, blue, opacity] = from.map((value, i) => Math.round(value + share * (to[i] - value)));
  return `rgba(${red}, ${green}, ${blue}, ${opacity / 255})`;
}

/** Return #rrggbb or #rrggbbaa as red, green, blue and opacity, 0 to 255. */
function channels(colour) {
  const parts = colour.slice(1).match(/../g).map((part) => parseInt(part, 16));
  return parts.length === 3 ? [...parts, 255] : parts;
}

/** Write a text: at its place, or beside its body. */
function drawWords(view, item, moment) {
  const { context, point, limits: [left, low, right, high] } = view;
  const { text, size, ink, align, level } = item;
  const [x, y] = item.places ? item.places[0] : besideBody(view, item, moment);
  const foot = y - item.drop * point / view.scale;
  if (x < left || x > right || foot < low || foot > high) return;
  view.pixels();
  context.fillStyle = ink;
  context.font = `${size * point}px ${FONT}`;
  Object.assign(context, { textAlign: align, textBaseline: level });
  context.fillText(text, view.column(x), view.row(foot));
}

/** Return where a text stands that belongs to a body: above it, or below where it would stand on a goal's flag. */
function besideBody({ items, theme: { label, flag }, point, scale }, { text, body, offset, size }, moment) {
  const [x, y] = body.poseAt(moment);
  if (offset) return [x + offset[0], y + offset[1]];
  const metres = (points) => points * point / scale;
  const [left, low, right, high] = body.boxAt(moment);
  const [middle, foot, height] = [(left + right) / 2, high + label.gap, metres(label.height * size)];
  const half = metres(label.letter / 2 * size * text.length);
  const flags = items.filter(({ rank }) => rank === "flags").flatMap(({ places }) => places);
  const isOnFlag = flags.some(([a, b]) => (
    a < middle + half && a + metres(flag[0]) > middle - half && b < foot + height && b + metres(flag[1]) > foot));
  return [middle, isOnFlag ? low - height : foot];
}

/** Draw a cover with soft borders over the cells that no robot has seen. */
function drawCover(view, { ink }, moment) {
  const { context, episode: { fog } } = view;
  const [x, y, right, top] = fog.extent;
  view.pixels();
  context.imageSmoothingQuality = "high";
  context.drawImage(fog.cover(moment, channels(ink)), view.column(x), view.row(top), (right - x) * view.scale, (top - y) * view.scale);
}
