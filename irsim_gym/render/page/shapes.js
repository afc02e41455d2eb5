// Shapes in the frame of a body, and colours.

/** Return the outline of a body as one path in its own frame. */
function outlinePath({ lines, discs }) {
  const path = new Path2D();
  for (const line of lines) {
    const closed = line.length > 4 && line[0] === line[line.length - 2] && line[1] === line[line.length - 1];
    line.forEach((x, i) => i % 2 || (i ? path.lineTo(x, line[i + 1]) : path.moveTo(x, line[1])));
    if (closed) path.closePath();
  }
  for (const [x, y, radius] of discs) {
    path.moveTo(x + radius, y);
    path.arc(x, y, radius, 0, 2 * Math.PI);
  }
  return path;
}

/** Return a closed polygon from x, y, x, y... */
function polygonPath(points) {
  const path = new Path2D();
  for (let i = 0; i < points.length; i += 2) path.lineTo(points[i], points[i + 1]);
  path.closePath();
  return path;
}

/** Return the box around an outline that stands at x, y, heading: x_min, y_min, x_max, y_max. */
function boxAround({ lines, discs }, x, y, heading) {
  const [cosine, sine] = [Math.cos(heading), Math.sin(heading)];
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  const add = (a, b, radius) => {
    const [across, up] = [x + cosine * a - sine * b, y + sine * a + cosine * b];
    box[0] = Math.min(box[0], across - radius);
    box[1] = Math.min(box[1], up - radius);
    box[2] = Math.max(box[2], across + radius);
    box[3] = Math.max(box[3], up + radius);
  };
  for (const line of lines) for (let i = 0; i < line.length; i += 2) add(line[i], line[i + 1], 0);
  for (const disc of discs) add(...disc);
  return box[0] <= box[2] ? box : [x, y, x, y];
}

/** Return #rrggbb or #rrggbbaa as red, green, blue (0 to 255) and opacity. */
function channels(colour) {
  const parts = colour.slice(1).match(/../g).map((part) => parseInt(part, 16));
  return [...parts.slice(0, 3), (parts[3] ?? 255) / 255];
}

/** Return a colour as CSS says it, with another opacity, and by default as bright as it is. */
function tinted(colour, alpha, brightness = 1) {
  const [red, green, blue] = channels(colour).map((value) => value * brightness);
  return `rgba(${red}, ${green}, ${blue}, ${Math.min(alpha, 1)})`;
}

/** Return a colour between two: that of the first for a share of 0. */
function between(first, second, share, alpha) {
  const [one, other] = [channels(first), channels(second)];
  const mixed = one.slice(0, 3).map((value, i) => Math.round(value + share * (other[i] - value)));
  return `rgba(${mixed.join(", ")}, ${alpha})`;
}

/** Return the dashes of a line style, in widths of the line. */
function dashes(style) {
  return { dashed: [3.7, 1.6], dashdot: [6.4, 1.6, 1, 1.6], dotted: [1, 1.65] }[style] ?? [];
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
