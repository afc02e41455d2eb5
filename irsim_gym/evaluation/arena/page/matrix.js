// Which policy solved which level: a column for each level, wrapped into as many blocks as the page is narrow.

const CELL = { height: 11, gap: 18, narrow: 8, wide: 16 };
const SOLVED = 0;  // the index of "success" among the outcomes

class Matrix {
  constructor(canvas, data, onChoose, onHover) {
    Object.assign(this, { canvas, data, onChoose, onHover, context: canvas.getContext("2d") });
    this.outcomes = data.outcomes.map((row) => Uint8Array.from(row, Number));
    this.colours = data.outcome_names.map((name) => data.colours[name]);
    this.recorded = new Set(data.replays.map(({ policy, level }) => `${policy} ${level}`));
    this.shown = data.levels.map((_, i) => i);
    this.chosen = null;
    canvas.addEventListener("click", (event) => {
      const cell = this.at(event);
      if (cell) onChoose(cell.level, cell.policy);
    });
    canvas.addEventListener("pointermove", (event) => onHover(this.at(event)));
    canvas.addEventListener("pointerleave", () => onHover(null));
    canvas.addEventListener("keydown", (event) => this.press(event));
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
  }

  get solvers() {
    this.known ??= this.data.levels.map((_, i) => this.outcomes.filter((row) => row[i] === SOLVED).length);
    return this.known;
  }

  /** Show those levels for which ``keep`` holds, in an order: hardest, easiest, number or pattern. */
  arrange(keep, order) {
    const { solvers, outcomes } = this;
    const pattern = (i) => outcomes.map((row) => (row[i] === SOLVED ? "1" : "0")).join("");
    const by = {
      hardest: (i, j) => solvers[i] - solvers[j] || pattern(i).localeCompare(pattern(j)) || i - j,
      easiest: (i, j) => solvers[j] - solvers[i] || pattern(j).localeCompare(pattern(i)) || i - j,
      number: (i, j) => i - j,
      outcome: (i, j) => (outcomes[0][j] - outcomes[0][i]) || solvers[i] - solvers[j] || i - j,
    }[order];
    this.shown = this.data.levels.map((_, i) => i).filter(keep).sort(by);
    this.draw();
  }

  layOut() {
    const { canvas, context, data } = this;
    const width = canvas.parentElement.clientWidth;
    const style = getComputedStyle(document.documentElement);
    this.page = (name) => style.getPropertyValue(`--${name}`).trim();
    context.font = `11px ${FONT}`;
    const longest = Math.max(...data.policies.map((name) => context.measureText(name).width));
    this.left = Math.min(longest, width * 0.3, 170) + 18;
    const room = width - this.left - 10;
    this.pitch = Math.min(Math.max(Math.floor(room / Math.max(this.shown.length, 1)), CELL.narrow), CELL.wide);
    this.columns = Math.max(Math.floor(room / this.pitch), 1);
    this.block = data.policies.length * CELL.height + CELL.gap;
    this.blocks = Math.max(Math.ceil(this.shown.length / this.columns), 1);
    const height = this.blocks * this.block + CELL.gap;
    const ratio = window.devicePixelRatio || 1;
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    canvas.style.height = `${height}px`;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  draw() {
    if (!this.canvas.parentElement.clientWidth) return;
    this.layOut();
    const { context, data, shown, columns } = this;
    Object.assign(context, { font: `11px ${FONT}`, textBaseline: "middle" });
    for (let block = 0; block < this.blocks; block++) {
      data.policies.forEach((name, policy) => {
        context.fillStyle = this.page("faint");
        context.fillText(cutTo(context, name, this.left - 16), 8, this.top(block, policy) + CELL.height / 2);
      });
    }
    shown.forEach((level, place) => {
      const [column, block] = [place % columns, Math.floor(place / columns)];
      this.outcomes.forEach((row, policy) => this.cell(row[level], this.recorded.has(`${policy} ${level}`), column, this.top(block, policy)));
      if (level === this.chosen) this.frame(column, block);
    });
  }

  top(block, policy) {
    return CELL.gap + block * this.block + policy * CELL.height;
  }

  /** Draw a failure as a full cell, light in its middle if there is a replay of it; a success as a low one. */
  cell(outcome, isRecorded, column, top) {
    const { context, pitch } = this;
    const x = this.left + column * pitch;
    context.fillStyle = this.colours[outcome];
    if (outcome === SOLVED) {
      context.globalAlpha = 0.5;
      context.fillRect(x + 1, top + CELL.height - 4, pitch - 2, 2);
      context.globalAlpha = 1;
      return;
    }
    context.fillRect(x + 1, top + 1, pitch - 2, CELL.height - 2);
    if (!isRecorded) return;
    context.fillStyle = this.page("panel");
    context.fillRect(x + 0.5 * pitch - 1, top + 4, 2, CELL.height - 8);
  }

  frame(column, block) {
    const { context } = this;
    context.strokeStyle = this.page("ink");
    context.lineWidth = 1.5;
    context.strokeRect(this.left + column * this.pitch - 0.5, this.top(block, 0) - 2, this.pitch + 1, this.block - CELL.gap + 4);
  }

  /** Return the level and policy at the mouse. */
  at(event) {
    const box = this.canvas.getBoundingClientRect();
    const column = Math.floor((event.clientX - box.left - this.left) / this.pitch);
    const y = event.clientY - box.top - CELL.gap / 2;
    const block = Math.floor(y / this.block);
    const policy = Math.floor((y - block * this.block - CELL.gap / 2) / CELL.height);
    const level = this.shown[block * this.columns + column];
    if (column < 0 || column >= this.columns || level === undefined) return null;
    return { level, policy: Math.min(Math.max(policy, 0), this.data.policies.length - 1) };
  }

  press(event) {
    const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -this.columns, ArrowDown: this.columns };
    const place = this.shown.indexOf(this.chosen);
    if (event.key in steps) {
      event.preventDefault();
      const next = place < 0 ? 0 : Math.min(Math.max(place + steps[event.key], 0), this.shown.length - 1);
      if (this.shown.length) this.onChoose(this.shown[next], null);
    } else if (event.key === "Enter" && place >= 0) {
      event.preventDefault();
      document.querySelector("#chosen button")?.click();
    }
  }

  /** Frame a level, and bring it into sight. */
  choose(level) {
    this.chosen = level;
    this.draw();
    const place = this.shown.indexOf(level);
    if (place < 0) return;
    const field = this.canvas.parentElement;
    const [top, foot] = [Math.floor(place / this.columns) * this.block, (Math.floor(place / this.columns) + 1) * this.block + CELL.gap];
    if (top < field.scrollTop) field.scrollTop = top;
    if (foot > field.scrollTop + field.clientHeight) field.scrollTop = foot - field.clientHeight;
  }
}
