// Keys and the mouse.

function listenToKeys(player) {
  const press = (id) => byId(id).click();
  const faster = (by) => {
    const select = byId("speed");
    select.selectedIndex = Math.min(Math.max(select.selectedIndex + by, 0), SPEEDS.length - 1);
  };
  const other = (by) => {
    const number = player.number + by;
    if (number >= 0 && number < player.recording.episodes.length) player.choose(number);
  };
  const zoom = (factor) => {
    player.world.zoomAt(factor);
    player.redraw();
  };
  const actions = {
    " ": () => player.play(!player.isPlaying),
    ArrowLeft: (event) => player.stepBy(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => player.stepBy(event.shiftKey ? 10 : 1),
    ArrowUp: () => faster(1),
    ArrowDown: () => faster(-1),
    Home: () => player.go(0),
    End: () => player.go(Infinity),
    PageUp: () => other(-1),
    PageDown: () => other(1),
    "+": () => zoom(1.25),
    "=": () => zoom(1.25),
    "-": () => zoom(0.8),
    0: () => player.whole(),
    s: () => press("scans"),
    t: () => press("paths"),
    n: () => press("names"),
    f: () => press("follow"),
    l: () => press("loop"),
  };
  document.addEventListener("keydown", (event) => {
    if (!player.isOpen) return;
    const isChoice = event.target.matches("select");
    const isButton = event.target.matches("button, summary, input[type=checkbox]") && event.key === " ";
    if (event.ctrlKey || event.metaKey || event.altKey || isChoice || isButton) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}

/** Both pictures show the same part of the world: whoever moves one moves the other. */
function listenToMouse(player) {
  for (const { canvas } of [player.world, player.second]) listenToMouseOn(canvas, player);
}

function listenToMouseOn(canvas, player) {
  const { world } = player;
  const held = new Map();
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [one, other] = [...held.values()];
    return Math.hypot(one[0] - other[0], one[1] - other[1]);
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    world.zoomAt(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...place(event));
    player.redraw();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, place(event));
    canvas.classList.add("held");
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const [column, row] = place(event);
    if (held.size === 2) {
      const wide = spread();
      held.set(event.pointerId, [column, row]);
      world.zoomAt(spread() / Math.max(wide, 1), column, row);
    } else if (!byId("follow").checked) {
      world.pan(column - before[0], row - before[1]);
      held.set(event.pointerId, [column, row]);
    }
    player.redraw();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      held.delete(event.pointerId);
      canvas.classList.toggle("held", held.size > 0);
    });
  }
  canvas.addEventListener("dblclick", () => player.whole());
}
