// The tables of an arena: figures, paired differences, easy and hard levels.

const percent = (share, digits = 1) => (share === null ? "\u2013" : (100 * share).toFixed(digits));
const signed = (share) => `${share > 0 ? "+" : share < 0 ? "\u2212" : ""}${Math.abs(100 * share).toFixed(1)}`;

/** Make an element with attributes, and texts or elements in it. */
function make(tag, attributes = {}, ...content) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.append(...content);
  return made;
}

function table(heads, rows) {
  const line = (cells) => make("tr", {}, ...cells);
  return make("table", {}, make("thead", {}, line(heads)), make("tbody", {}, ...rows.map(line)));
}

const head = (text, title = "") => make("th", { title, scope: "col" }, text);
const rowHead = (text) => make("th", { scope: "row", title: text }, text);

/** Return a share with its interval as a cell; ``bar`` draws both. */
function shareCell({ value, low, high }, bar = false) {
  const cell = make("td", {}, percent(value), make("small", {}, `${percent(low)} \u2013 ${percent(high)}`));
  if (bar) {
    const part = (name, from, to) => {
      const made = make("i", { className: name });
      Object.assign(made.style, { left: `${100 * from}%`, width: `${100 * (to - from)}%` });
      return made;
    };
    cell.append(make("span", { className: "bar" }, part("value", 0, value), part("range", low, high)));
  }
  return cell;
}

function tint(cell, share) {
  cell.classList.add("tinted");
  cell.style.setProperty("--share", `${Math.round(55 * share)}%`);
  return cell;
}

function showFigures({ policies, table: columns }) {
  const place = document.querySelector("#figures .wide");
  let [by, falls] = [null, true];
  const order = () => {
    const rows = policies.map((_, i) => i);
    const value = (i) => columns[by].cells[i].value ?? -Infinity;
    return by === null ? rows : rows.sort((i, j) => (falls ? value(j) - value(i) : value(i) - value(j)));
  };
  const draw = () => {
    const heads = columns.map(({ head: text, about }, c) => {
      const mark = by === c ? (falls ? " \u25be" : " \u25b4") : "";
      const button = make("button", { type: "button", title: about }, text + mark);
      button.addEventListener("click", () => {
        [by, falls] = [c, by === c ? !falls : true];
        draw();
      });
      const cell = make("th", { scope: "col", ariaSort: by === c ? (falls ? "descending" : "ascending") : "none" }, button);
      return cell;
    });
    const cell = ({ digits, cells }, c, i) => {
      if (!digits) return shareCell(cells[i], c === 0);
      return make("td", {}, cells[i].value === null ? "\u2013" : cells[i].value.toFixed(digits));
    };
    const rows = order().map((i) => [rowHead(policies[i]), ...columns.map((column, c) => cell(column, c, i))]);
    place.replaceChildren(table([head("policy"), ...heads], rows));
  };
  draw();
}

function showPairs({ pairs, policies: names }) {
  const section = document.getElementById("pairs");
  section.hidden = !pairs.length;
  if (section.hidden) return;
  const cell = (one, other) => {
    if (one === other) return make("td", {}, "\u00b7");
    const found = pairs.find((each) => each.one === one && each.other === other);
    const pair = found ?? pairs.find((each) => each.one === other && each.other === one);
    const sign = found ? 1 : -1;
    const ends = [pair.success.low, pair.success.high].map((end) => (end === null ? null : sign * end));
    const [low, high] = found ? ends : [ends[1], ends[0]];
    const [mine, theirs] = found ? [pair.only_one, pair.only_other] : [pair.only_other, pair.only_one];
    const isClear = pair.p_adjusted < 0.05;
    const words = signed(sign * pair.success.value);
    const interval = low === null ? "\u2013" : `${signed(low)} to ${signed(high)}`;
    const spl = sign * pair.spl.value;
    return make("td", {
      title: `${mine} levels that only ${one} solved, ${theirs} that only ${other} solved; McNemar p = ${pair.p.toPrecision(2)}, `
        + `adjusted ${pair.p_adjusted.toPrecision(2)}; SPL ${spl < 0 ? "\u2212" : "+"}${Math.abs(spl).toFixed(3)}`,
    }, isClear ? make("b", {}, words) : words, make("small", {}, interval), make("small", {}, `${mine} : ${theirs}`));
  };
  const rows = names.map((one) => [rowHead(one), ...names.map((other) => cell(one, other))]);
  section.querySelector(".wide").replaceChildren(table([head("row \u2212 column"), ...names.map((name) => head(name))], rows));
  section.querySelector(".note").textContent = "Difference of success in percentage points, with its 95 % interval from a paired "
    + "bootstrap over levels, and how many levels only the row or only the column solved. Bold: McNemar's exact test, adjusted "
    + `for ${pairs.length} comparison${pairs.length === 1 ? "" : "s"} (Benjamini and Hochberg), gives p < 0.05.`;
}

function showStrata({ strata, policies }) {
  const section = document.getElementById("strata");
  section.hidden = !strata.rows.length;
  if (section.hidden) return;
  const rows = policies.map((policy, i) => [rowHead(policy), ...strata.rows.map(({ success, levels }) => {
    if (!levels[i]) return make("td", { title: "no such level" }, "\u2013");
    const { value, low, high } = success[i];
    const cell = make("td", { title: `${percent(low)} \u2013 ${percent(high)} %` }, percent(value, 0), make("small", {}, `of ${levels[i]}`));
    return tint(cell, value);
  })]);
  section.querySelector(".wide").replaceChildren(table([head("policy"), ...strata.rows.map(({ name }) => head(name))], rows));
  section.querySelector(".note").textContent = !strata.by.includes("other policies")
    ? `Success [%] ${strata.by}: the difficulty that the certificate of the levels states.`
    : "Success [%] by how many of the other policies in this arena fail on the level: no certificate says how hard these "
      + "levels are. A policy's own failures do not count, so its columns hold other levels than those of another policy.";
}

/** Return where a policy is from, and what it observes, in words. */
function toldOf({ source, sha256, observes }) {
  const from = [source, sha256].filter(Boolean).join(", sha256 ") || "\u2013";
  return observes ? `${from}; observes ${observes.join(", ")}` : from;
}

/** List facts: nested mappings by dotted names. */
function showFacts({ facts }) {
  const list = document.querySelector("#facts dl");
  const walk = (value, name) => {
    const isMapping = value !== null && typeof value === "object" && !Array.isArray(value);
    if (isMapping) {
      for (const [key, part] of Object.entries(value)) walk(part, name ? `${name}.${key}` : key);
    } else if (name === "arena.policies") {
      value.forEach((policy) => list.append(make("dt", {}, policy.name), make("dd", {}, toldOf(policy))));
    } else {
      list.append(make("dt", {}, name.replaceAll("_", " ")), make("dd", {}, Array.isArray(value) ? JSON.stringify(value) : String(value ?? "\u2013")));
    }
  };
  walk(facts, "");
}
