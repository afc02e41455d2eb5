// Marks that somebody drew over the world: lines and areas, points, texts.

/** Return whether a mark is seen at a moment. */
function isSeen({ spans }, moment) {
  return spans.some(([first, end]) => first <= moment && moment < end);
}

function drawOver(view, mark) {
  if ("text" in mark) writeMark(view, mark);
  else if ("form" in mark) drawPoints(view, mark);
  else drawLine(view, mark);
}

function placesOf({ points, count }) {
  return Array.from({ length: count }, (_, i) => [points.at(i, 0), points.at(i, 1)]);
}

function drawLine(view, mark) {
  const { context } = view;
  const path = remembered(view, mark, () => {
    const way = new Path2D();
    for (const [x, y] of placesOf(mark)) way.lineTo(x, y);
    if (mark.closed) way.closePath();
    return way;
  });
  view.metres();
  if (mark.fill) {
    context.fillStyle = tinted(mark.fill, mark.fill_alpha);
    context.fill(path);
  }
  if (!mark.width) return;
  view.line(mark.width, mark.style);
  Object.assign(context, { lineCap: "butt", lineJoin: "round", strokeStyle: tinted(mark.colour, mark.alpha) });
  context.stroke(path);
}

function drawPoints(view, mark) {
  const { context, point } = view;
  const size = mark.size * point;
  view.pixels();
  context.setLineDash([]);
  context.lineWidth = mark.width * point;
  Object.assign(context, { lineCap: "butt", lineJoin: "round" });
  context.fillStyle = context.strokeStyle = tinted(mark.colour, mark.alpha);
  for (const [x, y] of placesOf(mark)) {
    const [column, row] = [view.column(x), view.row(y)];
    context.beginPath();
    if (!mark.form.length) context.arc(column, row, size / 2, 0, 2 * Math.PI);
    for (const part of mark.form) {
      for (let i = 0; i < part.length; i += 2) {
        const [a, b] = [column + size * part[i], row - size * part[i + 1]];
        if (i) context.lineTo(a, b);
        else context.moveTo(a, b);
      }
    }
    if (mark.width) context.stroke();
    else context.fill();
  }
}

function writeMark(view, mark) {
  const { context, limits: [left, low, right, high] } = view;
  const [x, y] = [mark.points.at(0, 0), mark.points.at(0, 1)];
  if (x < left || x > right || y < low || y > high) return;
  view.pixels();
  context.fillStyle = tinted(mark.colour, mark.alpha);
  context.font = `${mark.size * view.point}px ${FONT}`;
  Object.assign(context, { textAlign: mark.align, textBaseline: "middle" });
  context.fillText(mark.text, view.column(x), view.row(y));
}
