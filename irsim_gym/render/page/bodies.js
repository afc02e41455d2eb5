// Bodies and what belongs to them: outlines, marks of heading, paths, fields of view, goals, names.

function poseOf(body, moment) {
  return [body.place.at(moment, 0), body.place.at(moment, 1), body.heading.at(moment, 0)];
}

/** Return a path that is made once for each thing that is drawn. */
function remembered(view, thing, make) {
  if (!view.paths.has(thing)) view.paths.set(thing, make());
  return view.paths.get(thing);
}

function drawBody(view, body, moment) {
  const { style } = body;
  const path = remembered(view, body, () => outlinePath(body));
  const pose = poseOf(body, moment);
  if (body.image) {
    drawImage(view, body.image, pose);
    return;
  }
  if (body.isFixed && body.filled) drawShadow(view, path, pose);
  drawOutline(view, path, body, style, pose);
}

/** Draw an outline; one of several parts has no edges where they overlap. */
function drawOutline(view, path, { filled, lines, discs }, style, pose) {
  const { context } = view;
  view.metres(...pose);
  const inParts = filled && style.alpha === 1 && lines.length + discs.length > 1;
  const width = filled ? style.line_width : style.wall_width;
  context.strokeStyle = style.edge_colour
    ? tinted(style.edge_colour, style.alpha) : tinted(style.colour, style.alpha, filled ? 0.68 : 1);
  context.fillStyle = tinted(style.colour, style.alpha);
  Object.assign(context, { lineCap: "round", lineJoin: "round" });
  view.line(inParts ? 2 * width : width, style.line_style);
  if (filled && !inParts) context.fill(path);
  if (width > 0) context.stroke(path);
  if (inParts) context.fill(path);
}

function drawImage(view, { picture, box: [left, bottom, right, top], alpha }, pose) {
  const { context } = view;
  if (!picture.complete) return;
  view.metres(...pose);
  context.translate(left, top);
  context.scale((right - left) / picture.width, (bottom - top) / picture.height);
  context.globalAlpha = alpha;
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0);
  context.globalAlpha = 1;
}

/** Draw a soft cover over the cells that nobody has seen. */
function drawFog(view, moment) {
  const { context, episode: { fog } } = view;
  const [columns, rows] = fog.size;
  const covered = fog.at(moment);
  const isCovered = (i, j) => covered[Math.min(Math.max(i, 0), columns - 1) * rows + Math.min(Math.max(j, 0), rows - 1)];
  const cover = remembered(view, fog, () => Object.assign(document.createElement("canvas"), { width: columns, height: rows }));
  const pixels = new ImageData(columns, rows);
  const [red, green, blue] = channels(fog.colour);
  for (let i = 0; i < columns; i++) {
    for (let j = 0; j < rows; j++) {
      let around = 0;
      if (isCovered(i, j)) for (let k = 0; k < 9; k++) around += isCovered(i + (k % 3) - 1, j + Math.floor(k / 3) - 1);
      pixels.data.set([red, green, blue, Math.round((255 * fog.alpha * around) / 9)], 4 * ((rows - 1 - j) * columns + i));
    }
  }
  cover.getContext("2d").putImageData(pixels, 0, 0);
  const [x, y, right, top] = fog.extent;
  view.pixels();
  context.imageSmoothingQuality = "high";
  context.drawImage(cover, view.column(x), view.row(top), (right - x) * view.scale, (top - y) * view.scale);
}

function drawShadow(view, path, pose) {
  const { context, theme } = view;
  for (const [points, alpha] of [[2.2, 0.05], [1.2, 0.07]]) {
    const shift = (points * view.point) / view.scale;
    view.metres(pose[0] + shift, pose[1] - shift, pose[2]);
    view.line(1.5);
    context.fillStyle = tinted(theme.shadow, alpha);
    context.strokeStyle = tinted(theme.shadow, 0.4 * alpha);
    context.fill(path);
    context.stroke(path);
  }
}

function drawMark(view, body, moment) {
  const [x, y, heading] = poseOf(body, moment);
  view.metres(x, y, heading + body.heading.at(moment, 1));
  view.context.fillStyle = tinted(body.style.arrow_colour, body.style.arrow_alpha * body.style.alpha);
  view.context.fill(remembered(view, body.mark, () => polygonPath(body.mark)));
}

function drawImpact(view, body, moment) {
  const path = remembered(view, body, () => outlinePath(body));
  view.metres(...poseOf(body, moment));
  for (const [points, alpha] of [[5, 0.25], [1.8, 1]]) {
    view.line(points);
    view.context.strokeStyle = tinted(view.theme.impact, alpha);
    view.context.stroke(path);
  }
}

/** Draw where a body has been: a thin line that fades towards its beginning, or a band as wide as the style says. */
function drawPath(view, body, moment) {
  const { context } = view;
  const { style, place } = body;
  const first = style.trajectory_length ? Math.max(moment + 1 - style.trajectory_length, 0) : 0;
  const apart = 1.5 / view.scale;
  const points = [];
  let [along, bin] = [0, -1];
  for (let k = first; k <= moment; k++) {
    const [x, y] = [place.at(k, 0), place.at(k, 1)];
    if (Number.isNaN(x)) continue;
    if (k > first && !Number.isNaN(place.at(k - 1, 0))) along += Math.hypot(x - place.at(k - 1, 0), y - place.at(k - 1, 1));
    if (Math.floor(along / apart) > bin || k === moment) points.push([x, y]);
    bin = Math.floor(along / apart);
  }
  if (points.length < 2) return;
  view.metres();
  view.line(1.9, style.trajectory_style);
  if (style.trajectory_width !== null) {
    context.lineWidth = style.trajectory_width;
    context.setLineDash(dashes(style.trajectory_style).map((dash) => dash * style.trajectory_width));
  }
  Object.assign(context, { lineCap: "butt", lineJoin: "round" });
  const parts = style.trajectory_width === null ? Math.min(FADE_STEPS, points.length - 1) : 1;
  let length = 0;
  for (let part = 0; part < parts; part++) {
    const begin = Math.floor((part * (points.length - 1)) / parts);
    const end = Math.floor(((part + 1) * (points.length - 1)) / parts);
    const strength = parts === 1 ? 1 : FAINTEST + ((1 - FAINTEST) * part) / (parts - 1);
    context.beginPath();
    for (let i = begin; i <= end; i++) context.lineTo(...points[i]);
    context.lineDashOffset = length;
    for (let i = begin; i < end; i++) length += Math.hypot(points[i + 1][0] - points[i][0], points[i + 1][1] - points[i][1]);
    context.strokeStyle = tinted(style.trajectory_colour, strength * style.trajectory_alpha);
    context.stroke();
  }
  context.lineDashOffset = 0;
}

/** Draw the outlines that a body has left behind. */
function drawGhosts(view, body, moment) {
  const { style, ghost } = body;
  const path = remembered(view, ghost, () => outlinePath(ghost));
  let moments = [];
  for (let k = 0; k <= moment; k += style.ghost_every) if (!Number.isNaN(body.place.at(k, 0))) moments.push(k);
  if (style.ghost_length) moments = moments.slice(-style.ghost_length);
  for (const k of moments) drawOutline(view, path, ghost, style.ghost, poseOf(body, k));
}

function drawField(view, body, moment) {
  const { context } = view;
  const { style, field: [span, radius] } = body;
  view.metres(...poseOf(body, moment));
  context.beginPath();
  if (span < 2 * Math.PI - 0.01) context.moveTo(0, 0);
  context.arc(0, 0, radius, -span / 2, span / 2);
  context.closePath();
  view.line(0.9);
  context.fillStyle = tinted(style.field_colour, style.field_alpha);
  context.strokeStyle = tinted(style.field_edge_colour, style.field_alpha);
  context.fill();
  context.stroke();
}

function drawGoal(view, { x, y, tolerance, heading, arrived, later, style }) {
  const { context, point, scale } = view;
  const colour = (share) => tinted(style.goal_colour, share * style.goal_alpha);
  const dot = (column, row, radius) => {
    context.beginPath();
    context.arc(column, row, radius, 0, 2 * Math.PI);
  };
  view.pixels();
  context.setLineDash([]);
  const [column, row] = [view.column(x), view.row(y)];
  dot(column, row, tolerance * scale);
  context.fillStyle = colour(arrived ? 0.3 : 0.14);
  context.fill();
  context.lineWidth = 1.1 * point;
  context.strokeStyle = colour(0.9);
  context.stroke();
  if (heading !== null) drawGoalArrow(view, column, row, tolerance * scale, heading, colour(0.9));
  context.fillStyle = colour(0.45);
  for (const [a, b] of later) {
    dot(view.column(a), view.row(b), 2.25 * point);
    context.fill();
  }
  context.beginPath();
  context.moveTo(column, row);
  context.lineTo(column, row - 10 * point);
  context.strokeStyle = context.fillStyle = colour(1);
  context.lineWidth = 1.3 * point;
  context.stroke();
  context.beginPath();
  for (const [a, b] of [[0, 10], [6.25, 7.75], [0, 5.5]]) context.lineTo(column + a * point, row - b * point);
  context.fill();
}

/** Point to where a body has to head at its goal; the shaft of the arrow ends at the goal's circle. */
function drawGoalArrow({ context, point }, column, row, radius, heading, colour) {
  const [across, down] = [Math.cos(heading), -Math.sin(heading)];
  const [neck, head, wide, thin] = [Math.max(radius, 7 * point), 6 * point, 3 * point, 0.55 * point];
  context.beginPath();
  for (const [a, b] of [[0, thin], [neck, thin], [neck, wide], [neck + head, 0], [neck, -wide], [neck, -thin], [0, -thin]]) {
    context.lineTo(column + a * across - b * down, row + a * down + b * across);
  }
  context.fillStyle = colour;
  context.fill();
}

/** Write a body's name above it, or below where it would stand on a flag. */
function drawLabel(view, body, moment, goals, { names }) {
  const { style } = body;
  const text = style.label || (names && !body.isFixed ? body.name : "");
  if (!text) return;
  const [x, y, heading] = poseOf(body, moment);
  const box = boxAround(body, x, y, heading);
  const own = style.label ? style.label_offset : null;
  const height = 1.3 * style.label_size * view.point;
  let [column, row] = own
    ? [view.column(x + own[0]), view.row(y + own[1])]
    : [view.column((box[0] + box[2]) / 2), view.row(box[3] + 0.08)];
  const half = 0.35 * style.label_size * text.length * view.point;
  const onFlag = goals.some((goal) => {
    const [left, foot] = [view.column(goal.x), view.row(goal.y)];
    const [right, top] = [left + FLAG_WIDTH * view.point, foot - FLAG_HEIGHT * view.point];
    return left < column + half && right > column - half && top < row && foot > row - height;
  });
  if (onFlag && !own) row = view.row(box[1]) + height;
  write(view, text, column, row, style);
}

/** Write a goal's name below its circle: its flag is above. */
function drawGoalLabel(view, { x, y, tolerance, style }) {
  if (!style.goal_label) return;
  const height = 1.3 * style.label_size * view.point;
  write(view, style.goal_label, view.column(x), view.row(y - tolerance) + height, style);
}

function write(view, text, column, row, style) {
  const { context, point } = view;
  view.pixels();
  context.fillStyle = tinted(style.label_colour, style.label_alpha);
  context.font = `${style.label_size * point}px ${FONT}`;
  Object.assign(context, { textAlign: "center", textBaseline: "bottom" });
  context.fillText(text, column, row);
}
