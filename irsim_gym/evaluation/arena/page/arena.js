// The page of an arena: what is chosen, and what the player plays.

class Arena {
  constructor(data) {
    this.data = data;
    this.player = new Player({ ...data, episodes: [] });
    this.player.isOpen = false;
    byId("title").textContent = data.title;
    showFigures(data);
    showPairs(data);
    showStrata(data);
    showFacts(data);
    this.matrix = new Matrix(byId("matrix"), data, (level, policy) => this.choose(level, policy), (cell) => this.hover(cell));
    this.fillChoices();
    this.showColours();
    this.showLeft();
    this.addClose();
    this.listen();
    this.arrange();
    this.choose(this.matrix.shown.find((level) => this.replaysOf(level).size) ?? 0, null);
    this.follow();
  }

  get names() {
    return this.data.policies;
  }

  fillChoices() {
    const { names } = this;
    const choices = [["all", "all levels"], ["differ", "levels on which policies differ"], ["nobody", "levels that nobody solves"],
      ...names.map((name, i) => [String(i), `levels that ${name} fails`])];
    byId("filter").append(...choices.map(([value, words]) => new Option(words, value)));
    const orders = [["hardest", "hardest first"], ["easiest", "easiest first"], ["number", "by number"],
      ["outcome", `by outcome of ${names[0]}`]];
    byId("order").append(...orders.map(([value, words]) => new Option(words, value)));
    byId("number").max = String(this.data.levels.at(-1));
  }

  showColours() {
    const { outcomes, colours } = this.matrix;
    const seen = new Set(outcomes.flatMap((row) => [...row]));
    byId("colours").append(...this.data.outcome_names.flatMap((name, i) => {
      if (!seen.has(i)) return [];
      const mark = make("i");
      Object.assign(mark.style, { background: colours[i], height: i === SOLVED ? "3px" : "11px" });
      return [make("li", {}, mark, name.replaceAll("_", " "))];
    }), make("li", {}, "a light middle: there is a replay"));
  }

  showLeft() {
    const { failures, shown, unlike } = this.data.left;
    const parts = [`${failures.toLocaleString("en")} episodes failed; this page plays ${shown.toLocaleString("en")} of them`];
    if (shown < failures) {
      parts.push("The policies took turns, each with its shortest failures first, those of levels that somebody solved before the others");
    }
    if (unlike) parts.push(`${unlike} were left out because they came to another end when they were played again: a policy has whims`);
    byId("left").textContent = `${parts.join(". ")}.`;
  }

  addClose() {
    const button = make("button", { id: "close", type: "button", title: "Back to the arena (escape)", ariaLabel: "Close" }, "\u2715");
    document.querySelector("#replay header").append(button);
    button.addEventListener("click", () => this.leave());
  }

  listen() {
    for (const id of ["filter", "order"]) byId(id).addEventListener("change", () => this.arrange());
    byId("number").addEventListener("change", () => {
      const level = this.data.levels.indexOf(Number(byId("number").value));
      if (level >= 0) this.choose(level, null);
    });
    byId("report-scheme").addEventListener("click", () => this.player.changeScheme());
    new MutationObserver(() => this.matrix.draw()).observe(document.documentElement, { attributeFilter: ["data-scheme"] });
    window.addEventListener("hashchange", () => this.follow());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.player.isOpen) this.leave();
    });
  }

  arrange() {
    const { outcomes } = this.matrix;
    const chosen = byId("filter").value;
    const solved = (i) => this.matrix.solvers[i];
    const keep = {
      all: () => true,
      differ: (i) => solved(i) > 0 && solved(i) < outcomes.length,
      nobody: (i) => solved(i) === 0,
    }[chosen] ?? ((i) => outcomes[Number(chosen)][i] !== SOLVED);
    this.matrix.arrange(keep, byId("order").value);
    byId("count").textContent = `${this.matrix.shown.length.toLocaleString("en")} of ${this.data.levels.length.toLocaleString("en")} levels`;
  }

  hover(cell) {
    byId("under").textContent = cell ? `level ${this.data.levels[cell.level]}, ${this.names[cell.policy]}: ${this.ended(cell.policy, cell.level)}` : "";
  }

  /** Say how an episode ended. */
  ended(policy, level) {
    const { agents, arrived, times, outcome_names: known } = this.data;
    const outcome = this.matrix.outcomes[policy][level];
    const words = known[outcome].replaceAll("_", " ");
    const count = agents > 1 && outcome !== SOLVED ? `${arrived[policy][level]} of ${agents} arrive; ` : "";
    return `${count}${words}, ${times[policy][level].toFixed(1)} s`;
  }

  /** Return the numbers of a level's replays, by policy. */
  replaysOf(level) {
    return new Map(this.data.replays.flatMap((replay, i) => (replay.level === level ? [[replay.policy, i]] : [])));
  }

  /** Show what became of a level; where a failed episode was clicked on that can be played, play it. */
  choose(level, policy) {
    const replays = this.replaysOf(level);
    this.matrix.choose(level);
    byId("number").value = String(this.data.levels[level]);
    const solver = [...replays.keys()].find((each) => this.matrix.outcomes[each][level] === SOLVED);
    const rows = this.names.map((name, i) => {
      const words = make("em", {}, this.ended(i, level));
      words.style.color = this.matrix.outcomes[i][level] === SOLVED ? "" : this.matrix.colours[this.matrix.outcomes[i][level]];
      const row = make("li", {}, make("strong", {}, name), make("span", {}, words));
      if (!replays.has(i)) return row;
      const button = (text, beside) => {
        const made = make("button", { type: "button" }, text);
        made.addEventListener("click", () => this.go(level, i, beside));
        row.append(made);
      };
      if (solver !== undefined && solver !== i) button(`play beside ${this.names[solver]}`, solver);
      button(solver !== undefined && solver !== i ? "alone" : "play", null);
      return row;
    });
    const heading = make("h3", {}, `Level ${this.data.levels[level]}`);
    const content = [heading, make("ul", {}, ...rows)];
    if (replays.size < this.names.length && this.command(level)) content.push(make("p", { className: "note" }, "Play any of them: ", make("code", {}, this.command(level))));
    byId("chosen").replaceChildren(...content);
    if (policy !== null && replays.has(policy) && this.matrix.outcomes[policy][level] !== SOLVED) this.go(level, policy, solver ?? null);
  }

  /** Return the command that records a level; none for plain data and functions, which have no name there. */
  command(level) {
    const { arena, conditions } = this.data.facts;
    const quoted = (text) => (/^[\w./=+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
    const sources = arena.policies.flatMap(({ source }) => (source === null ? [] : [quoted(source)]));
    if (arena.source === null || !sources.length) return null;
    const given = Object.entries(conditions.parameters).flatMap(([key, value]) => ["--set", quoted(`${key}=${value}`)]);
    return ["irsim-gym record", quoted(arena.source), ...sources, "--level", this.data.levels[level], "--split", arena.split,
      ...(arena.team ? ["--team"] : []), ...(arena.task === null ? [] : ["--task", quoted(arena.task)]), ...given, "--html"].join(" ");
  }

  /** Go to an episode; the address says which, so that the browser goes back from it. */
  go(level, policy, beside) {
    window.location.hash = ["", "play", this.data.levels[level], policy, ...(beside === null ? [] : [beside])].join("/");
  }

  leave() {
    window.location.hash = "#/";
  }

  /** Show what the address says. */
  async follow() {
    const [, word, number, ...places] = window.location.hash.split("/");
    const level = this.data.levels.indexOf(Number(number));
    const replays = this.replaysOf(level);
    const [policy, beside] = places.map(Number);
    const isOpen = word === "play" && replays.has(policy);
    if (isOpen) {
      const shown = [...replays.keys()];
      const episodes = await Promise.all(shown.map((each) => readRecording(byId(`replay-${replays.get(each)}`).textContent)));
      this.player.take(episodes, shown.indexOf(policy), replays.has(beside) ? shown.indexOf(beside) : null);
      this.matrix.choose(level);
    }
    byId("replay").hidden = !isOpen;
    document.body.classList.toggle("playing", isOpen);
    this.player.play(isOpen);
    this.player.isOpen = isOpen;
    if (isOpen) {
      this.before ??= document.activeElement;
      byId("play").focus();
    } else {
      this.before?.focus({ preventScroll: true });
      this.before = null;
    }
  }
}

async function showArena() {
  try {
    window.arena = new Arena(await readRecording(byId("data").textContent));
  } catch (problem) {
    byId("report").replaceChildren(make("p", { className: "problem" }, `This arena cannot be shown: ${problem.message}`));
    throw problem;
  }
}

showArena();
