// Values of a robot over time, with a cursor at the present moment.

const LINE_COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8b5cf6", "#a3a100", "#dc2626", "#0f766e"];
const UNITS = {
  speed: "m/s", turn_rate: "rad/s", clearance: "m", goal_distance: "m", reward: "", total: "",
};

class Chart {
  constructor(canvas, legend, onSeek) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.legend = legend;
    this.hidden = new Set();
    this.lines = [];
    const seek = (event) => {
      const { left, width } = this.plot;
      const share = (event.clientX - canvas.getBoundingClientRect().left - left) / width;
      onSeek(Math.min(Math.max(share, 0), 1) * this.episode.duration);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.episode) return;
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && seek(event));
  }

  /** Return the plots that there are for a robot: name, words, lines. */
  static kinds(agent) {
    const found = [];
    const terms = Object.entries(agent.terms);
    const { reward, ...others } = agent.values;
    if (reward) {
      const rewards = [...terms, ["total", reward]];
      found.push(["sum", "reward terms, summed up", () => rewards.map(([name, table]) => [name, summed(table)])]);
      found.push(["step", "reward terms of each step", () => rewards]);
    }
    for (const [name, table] of Object.entries(others)) {
      found.push([name, `${name.replaceAll("_", " ")}${UNITS[name] ? ` [${UNITS[name]}]` : ""}`, () => [[name, table]]]);
    }
    if (agent.action) {
      const columns = Array.from({ length: agent.action.width }, (_, i) => [`action ${i + 1}`, { at: (k) => agent.action.at(k, i) }]);
      found.push(["action", "action", () => columns]);
    }
    return found;
  }

  /** Show a plot of an episode. */
  show(episode, lines) {
    this.episode = episode;
    this.lines = lines.map(([name, table], i) => ({
      name, table, colour: name === "total" ? null : LINE_COLOURS[i % LINE_COLOURS.length],
    }));
    this.legend.replaceChildren(...this.lines.map((line) => this.entry(line)));
    this.fit();
  }

  entry(line) {
    const [item, button, mark, number] = ["li", "button", "i", "b"].map((name) => document.createElement(name));
    mark.style.background = line.colour ?? "var(--ink)";
    button.type = "button";
    button.title = "Show or hide this line";
    button.append(mark, line.name.replaceAll("_", " "), number);
    const update = () => button.setAttribute("aria-pressed", String(!this.hidden.has(line.name)));
    button.addEventListener("click", () => {
      if (!this.hidden.delete(line.name)) this.hidden.add(line.name);
      update();
      this.fit();
      this.draw(this.moment);
    });
    update();
    line.number = number;
    item.append(button);
    return item;
  }

  /** Find the range of the shown values; single peaks, such as the reward of the arrival, may leave it. */
  fit() {
    const values = [];
    for (const { name, table } of this.lines) {
      if (this.hidden.has(name)) continue;
      for (let k = 0; k < this.episode.count; k++) if (!Number.isNaN(table.at(k))) values.push(table.at(k));
    }
    values.sort((one, other) => one - other);
    const at = (share) => values[Math.round(share * (values.length - 1))] ?? 0;
    let [low, high] = [at(0), at(1)];
    const [usualLow, usualHigh] = [at(0.01), at(0.99)];
    const usual = Math.max(usualHigh - usualLow, 1e-9);
    if (high - low > 8 * usual && usual > 1e-9) [low, high] = [Math.max(low, usualLow - usual), Math.min(high, usualHigh + usual)];
    low = Math.min(low, 0);
    high = Math.max(high, 0);
    const pad = 0.06 * (high - low || 1);
    this.range = [low === 0 ? low : low - pad, high === 0 && low < 0 ? high : high + pad];
  }

  draw(moment) {
    if (!this.episode) return;
    this.moment = moment;
    const { canvas, context, episode, lines } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const [columns, rows] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    this.plot = { left: 46, top: 8, width: width - 54, height: height - 30 };
    const style = getComputedStyle(document.documentElement);
    this.drawAxes((name) => style.getPropertyValue(`--${name}`).trim());
    context.save();
    context.beginPath();
    context.rect(this.plot.left, this.plot.top - 1, this.plot.width, this.plot.height + 2);
    context.clip();
    for (const line of lines) if (!this.hidden.has(line.name)) this.drawLine(line, style.getPropertyValue("--ink"));
    context.strokeStyle = style.getPropertyValue("--accent");
    context.lineWidth = 1.5;
    const now = this.column(episode.time.at(moment));
    context.beginPath();
    context.moveTo(now, this.plot.top);
    context.lineTo(now, this.plot.top + this.plot.height);
    context.stroke();
    context.restore();
    for (const { table, number } of lines) number.textContent = written(table.at(moment), 4);
  }

  column(time) {
    return this.plot.left + (time / (this.episode.duration || 1)) * this.plot.width;
  }

  row(value) {
    const [low, high] = this.range;
    return this.plot.top + ((high - value) / (high - low)) * this.plot.height;
  }

  drawAxes(colour) {
    const { context, plot, episode, range } = this;
    context.font = `11px ${FONT}`;
    context.lineWidth = 1;
    Object.assign(context, { textAlign: "right", textBaseline: "middle" });
    for (const value of ticks(...range, plot.height * 1.6)) {
      context.strokeStyle = colour(Math.abs(value) < 1e-12 ? "faint" : "rule");
      context.beginPath();
      context.moveTo(plot.left, this.row(value));
      context.lineTo(plot.left + plot.width, this.row(value));
      context.globalAlpha = Math.abs(value) < 1e-12 ? 0.8 : 0.45;
      context.stroke();
      context.globalAlpha = 1;
      context.fillStyle = colour("faint");
      context.fillText(short(value), plot.left - 6, this.row(value));
    }
    Object.assign(context, { textAlign: "center", textBaseline: "top" });
    const times = ticks(0, episode.duration || 1, 1.5 * plot.width);
    times.forEach((time, i) => {
      const last = i === times.length - 1;
      context.fillText(short(time) + (last ? " s" : ""), Math.min(this.column(time), plot.left + plot.width - 12), plot.top + plot.height + 6);
    });
  }

  drawLine({ table, colour }, ink) {
    const { context, episode } = this;
    context.strokeStyle = colour ?? ink;
    context.lineWidth = colour ? 1.5 : 2;
    context.lineJoin = "round";
    context.beginPath();
    let isOpen = false;
    for (let k = 0; k < episode.count; k++) {
      const value = table.at(k);
      if (Number.isNaN(value)) {
        isOpen = false;
        continue;
      }
      const place = [this.column(episode.time.at(k)), this.row(value)];
      if (isOpen) context.lineTo(...place);
      else context.moveTo(...place);
      isOpen = true;
    }
    context.stroke();
  }
}

/** Return the running sums of a table's first column. */
function summed(table) {
  const sums = [];
  return {
    at: (moment) => {
      while (sums.length <= moment) sums.push((sums.at(-1) ?? 0) + (table.at(sums.length) || 0));
      return sums[moment];
    },
  };
}

/** Return a number as text with so many significant digits; a dash for none. */
function written(value, digits) {
  if (value === undefined || Number.isNaN(value)) return "\u2013";
  const rounded = Number(value.toPrecision(digits));
  const text = Math.abs(rounded) >= 0.001 || rounded === 0 ? String(Number(rounded.toFixed(4))) : rounded.toExponential(1);
  return text.replace("-", "\u2212");
}
