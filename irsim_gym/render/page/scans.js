// What range sensors see: the area, the beams, and the points that they hit.

/** Return where the beams end, and which of them hit. */
function beamsOf(scan, moment) {
  const [x, y, heading] = [scan.place.at(moment, 0), scan.place.at(moment, 1), scan.heading.at(moment)];
  const ranges = scan.ranges.row(moment);
  const far = scan.far ?? Infinity;
  const ends = scan.angles.map((angle, i) => [
    x + ranges[i] * Math.cos(heading + angle), y + ranges[i] * Math.sin(heading + angle),
  ]);
  const hits = Array.from(ranges, (range) => range < far);
  const valid = Array.from(ranges, (range) => range < far && range > scan.near);
  return { x, y, ends, hits, valid };
}

function drawScan(view, scan, moment) {
  const { context } = view;
  const { style } = scan;
  const beams = beamsOf(scan, moment);
  view.metres();
  if (style.velocity?.coloured) {
    drawVelocities(view, scan, moment, beams);
    return;
  }
  context.beginPath();
  if (!scan.surrounds) context.moveTo(beams.x, beams.y);
  for (const end of beams.ends) context.lineTo(...end);
  context.closePath();
  context.fillStyle = tinted(style.colour, 0.22 * style.alpha);
  context.fill();
  const every = Math.ceil(beams.ends.length / MOST_BEAMS);
  view.line(0.45);
  context.strokeStyle = tinted(style.colour, Math.min(0.9 * style.alpha, 1));
  strokeRays(context, beams, beams.ends.filter((_, i) => i % every === 0));
}

function strokeRays(context, { x, y }, ends) {
  context.beginPath();
  for (const end of ends) {
    context.moveTo(x, y);
    context.lineTo(...end);
  }
  context.stroke();
}

function drawVelocities(view, scan, moment, beams) {
  const { context } = view;
  const { velocity, alpha } = scan.style;
  view.line(velocity.free_width);
  context.strokeStyle = tinted(velocity.free_colour, velocity.free_alpha);
  strokeRays(context, beams, beams.ends.filter((_, i) => !beams.valid[i]));
  view.line(velocity.width);
  beams.ends.forEach((end, i) => {
    if (!beams.valid[i]) return;
    context.strokeStyle = speedColour(velocity, scan.speeds?.at(moment, i) ?? 0, alpha);
    strokeRays(context, beams, [end]);
  });
}

/** Return the colour of a beam: the sign's, mixed with that of rest below the full speed. */
function speedColour(velocity, speed, alpha) {
  const share = Math.min(Math.abs(speed) / velocity.full_speed, 1);
  return between(velocity.rest_colour, speed >= 0 ? velocity.away_colour : velocity.nearer_colour, share, alpha);
}

function drawHits(view, scan, moment) {
  const { context, point } = view;
  const { style } = scan;
  const { velocity } = style;
  const beams = beamsOf(scan, moment);
  const shown = velocity ? beams.valid : beams.hits;
  if (velocity && velocity.mark_size <= 0) return;
  const radius = (velocity ? Math.sqrt(velocity.mark_size) / 2 : 1.3) * point;
  view.pixels();
  context.setLineDash([]);
  context.fillStyle = tinted(style.colour, Math.min(3 * style.alpha, 1));
  beams.ends.forEach(([x, y], i) => {
    if (!shown[i]) return;
    context.beginPath();
    context.arc(view.column(x), view.row(y), radius, 0, 2 * Math.PI);
    if (velocity) context.fillStyle = speedColour(velocity, scan.speeds?.at(moment, i) ?? 0, 1);
    context.fill();
    if (!velocity || velocity.mark_edge_width <= 0) return;
    context.lineWidth = velocity.mark_edge_width * point;
    context.strokeStyle = tinted(velocity.mark_edge_colour, 1);
    context.stroke();
  });
}
