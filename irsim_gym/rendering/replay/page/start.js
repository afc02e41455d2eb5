// Plays the recording that the page holds.

async function start() {
  try {
    window.player = new Player(await readRecording(byId("data").textContent));
  } catch (problem) {
    const words = document.createElement("p");
    words.className = "problem";
    words.textContent = `This recording cannot be played: ${problem.message}`;
    byId("stage").replaceChildren(words);
    throw problem;
  }
}

start();
