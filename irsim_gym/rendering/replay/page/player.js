// The controls: what is shown, when, and how fast.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
const HELD_AT_THE_END = 0.8;
const byId = (id) => document.getElementById(id);

/** Plays one episode, or two side by side at the same time; the longer of the two is the timeline. */
class Player {
  constructor(recording) {
    this.recording = {
      ...recording,
      pens: recording.pens.map((pen) => ({ ...recording.theme.defaults.Pen, ...pen })),
      shapes: recording.shapes.map((shape) => new Shape(shape)),
      pictures: recording.pictures.map((source) => this.picture(source)),
    };
    this.moment = 0;
    this.clock = 0;
    this.isPlaying = false;
    this.isOpen = true;
    this.agent = 0;
    this.kind = null;
    this.isDue = false;
    this.world = new WorldView(byId("world"), recording.theme);
    this.second = new WorldView(byId("other"), recording.theme);
    this.chart = new Chart(byId("chart"), byId("legend"), (time) => this.go(this.timeline.momentAt(time)));
    byId("heading").textContent = recording.title;
    byId("speed").append(...SPEEDS.map((speed) => new Option(`${speed} \u00d7`, speed, speed === 1, speed === 1)));
    this.listen();
    listenToKeys(this);
    listenToMouse(this);
    if (recording.episodes.length) this.take(recording.episodes);
  }

  /** Put these episodes into the lists; show one, and perhaps another one beside it. */
  take(episodes, number = 0, beside = null) {
    this.recording.episodes = episodes;
    const options = () => episodes.map(({ name }, i) => new Option(name, i));
    byId("episode").replaceChildren(...options());
    byId("beside").replaceChildren(new Option("nothing", ""), ...options());
    for (const id of ["episodes", "besides"]) byId(id).hidden = episodes.length < 2;
    this.other = null;
    this.choose(number);
    this.pair(beside);
  }

  listen() {
    const on = (id, event, action) => byId(id).addEventListener(event, action);
    on("episode", "change", () => this.choose(Number(byId("episode").value)));
    on("beside", "change", () => this.pair(byId("beside").value === "" ? null : Number(byId("beside").value)));
    on("agent", "change", () => this.chooseAgent(Number(byId("agent").value)));
    on("kind", "change", () => this.choosePlot(byId("kind").value));
    on("moment", "input", () => this.go(Number(byId("moment").value)));
    on("play", "click", () => this.play(!this.isPlaying));
    on("back", "click", () => this.stepBy(-1));
    on("forth", "click", () => this.stepBy(1));
    on("whole", "click", () => this.whole());
    on("scheme", "click", () => this.changeScheme());
    for (const id of ["scans", "paths", "names", "follow"]) on(id, "change", () => this.redraw());
    window.addEventListener("resize", () => this.redraw());
    new ResizeObserver(() => this.redraw()).observe(byId("stage"));
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.setScheme(dark.matches));
    this.setScheme(dark.matches);
  }

  /** Return a picture that is drawn as soon as it is there. */
  picture(source) {
    const image = new Image();
    image.addEventListener("load", () => this.redraw());
    image.src = source;
    return image;
  }

  setScheme(isDark) {
    document.documentElement.dataset.scheme = isDark ? "dark" : "light";
    this.redraw();
  }

  changeScheme() {
    this.setScheme(document.documentElement.dataset.scheme !== "dark");
  }

  choose(number) {
    const data = this.recording.episodes[number];
    this.number = number;
    this.episode = new Episode(data, this.recording);
    byId("episode").value = String(number);
    byId("name").textContent = data.name;
    byId("agent").replaceChildren(...this.episode.agents.map(({ name }, i) => new Option(name, i)));
    byId("who").hidden = this.episode.agents.length < 2;
    byId("plot").hidden = !this.episode.agents.length;
    this.world.show(this.episode);
    this.chooseAgent(Math.min(this.agent, Math.max(this.episode.agents.length - 1, 0)));
    this.fit();
    this.go(0);
  }

  /** Show another episode beside the chosen one, or none. */
  pair(number) {
    this.other = number === null ? null : new Episode(this.recording.episodes[number], this.recording);
    byId("beside").value = number === null ? "" : String(number);
    byId("companion").hidden = !this.other;
    byId("stage").classList.toggle("paired", Boolean(this.other));
    if (this.other) {
      byId("other-name").textContent = this.other.name;
      this.second.show(this.other);
    }
    this.fit();
    this.go(this.timeline.momentAt(this.clock));
  }

  /** Let the longer one of the shown episodes be the timeline. */
  fit() {
    this.timeline = this.other && this.other.duration > this.episode.duration ? this.other : this.episode;
    byId("moment").max = String(this.timeline.count - 1);
  }

  /** Return the moment of an episode that is shown now: its last one once it has ended. */
  momentOf(episode) {
    return episode === this.timeline ? this.moment : episode.momentAt(this.timeline.time.at(this.moment));
  }

  chooseAgent(number) {
    this.agent = number;
    const agent = this.episode.agents[number];
    if (!agent) {
      this.redraw();
      return;
    }
    byId("agent").value = String(number);
    const kinds = Chart.kinds(agent);
    byId("kind").replaceChildren(...kinds.map(([name, words]) => new Option(words, name)));
    this.choosePlot(kinds.some(([name]) => name === this.kind) ? this.kind : kinds[0][0]);
  }

  choosePlot(name) {
    this.kind = name;
    byId("kind").value = name;
    const [, , lines] = Chart.kinds(this.episode.agents[this.agent]).find(([kind]) => kind === name);
    this.chart.show(this.episode, lines());
    this.redraw();
  }

  whole() {
    this.world.whole();
    byId("follow").checked = false;
    this.redraw();
  }

  /** Go to a moment. */
  go(moment) {
    this.moment = Math.min(Math.max(moment, 0), this.timeline.count - 1);
    this.clock = this.timeline.time.at(this.moment);
    this.redraw();
  }

  stepBy(count) {
    this.play(false);
    this.go(this.moment + count);
  }

  play(isPlaying) {
    if (isPlaying && this.moment === this.timeline.count - 1) this.go(0);
    this.isPlaying = isPlaying;
    byId("play").textContent = isPlaying ? "\u275a\u275a" : "\u25b6\ufe0e";
    byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    byId("play").title = isPlaying ? "Pause (space)" : "Play (space)";
    this.before = null;
    if (isPlaying) requestAnimationFrame((now) => this.tick(now));
  }

  /** Let the clock run on; at the end of the episode it stops, or begins again. */
  tick(now) {
    if (!this.isPlaying) return;
    this.clock += this.before === null ? 0 : ((now - this.before) / 1000) * Number(byId("speed").value);
    this.before = now;
    const { duration } = this.timeline;
    const isLooping = byId("loop").checked;
    if (this.clock >= duration + (isLooping ? HELD_AT_THE_END * Number(byId("speed").value) : 0)) {
      if (isLooping) this.clock = 0;
      else this.play(false);
    }
    const moment = this.timeline.momentAt(this.clock);
    if (moment !== this.moment) {
      this.moment = moment;
      this.redraw();
    }
    requestAnimationFrame((later) => this.tick(later));
  }

  /** Draw at the next opportunity, once. */
  redraw() {
    if (this.isDue || !this.episode) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.draw();
    });
  }

  draw() {
    const { episode, other, timeline } = this;
    const moment = this.momentOf(episode);
    const agent = episode.agents[this.agent];
    const shown = (id) => byId(id).checked;
    const robot = agent?.name ?? episode.bodies.find((body) => !body.fixed)?.name;
    const follow = shown("follow") ? robot : null;
    const options = { scans: shown("scans"), paths: shown("paths"), names: shown("names"), follow };
    this.world.draw(moment, options);
    if (other) {
      this.second.look = this.world.look;
      this.second.draw(this.momentOf(other), options);
    }
    if (agent) this.chart.draw(moment);
    byId("moment").value = String(this.moment);
    byId("clock").textContent = `${timeline.time.at(this.moment).toFixed(1)} / ${timeline.duration.toFixed(1)} s`;
    const rows = this.values(agent, moment);
    byId("values").replaceChildren(...rows.flatMap(([name, value]) => {
      const [term, words] = ["dt", "dd"].map((tag) => document.createElement(tag));
      term.textContent = name;
      words.textContent = value;
      return [term, words];
    }));
  }

  /** Return the names and values that the panel shows of the robot at this moment. */
  values(agent, moment) {
    const { episode } = this;
    const rows = Object.entries(episode.details);
    rows.push(["step", `${moment} of ${episode.count - 1}`]);
    if (!agent) return rows;
    const outcome = valueAt(agent.outcome, moment);
    if (outcome) rows.push(["outcome", outcome.replaceAll("_", " ")]);
    if (agent.action) rows.push(["action", [...agent.action.row(moment)].map((value) => written(value, 3)).join(", ")]);
    for (const [name, table] of Object.entries(agent.values)) {
      const unit = UNITS[name] ? ` ${UNITS[name]}` : "";
      rows.push([name.replaceAll("_", " "), written(table.at(moment), 4) + unit]);
    }
    if (agent.values.reward) rows.push(["return so far", written(summed(agent.values.reward).at(moment), 4)]);
    return rows;
  }
}
