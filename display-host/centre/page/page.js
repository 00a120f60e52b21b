"use strict";
// Stations as tiles, and one of them enlarged.
const SILENT_MS = 3000; // states come twice a second
const FLASH_MS = 10000;
const stations = new Map();
let socket = null;
let large = null;

const byId = (id) => document.getElementById(id);

function both(said) {
  return said ? said[LANGUAGE] : "";
}

function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

function tileOf(name) {
  const known = stations.get(name);
  if (known) return known;
  const button = make("button", null, "tile");
  const tile = { name, button, told: null, heard: 0, alarms: null, url: null };
  tile.picture = make("img");
  tile.picture.alt = "";
  tile.parts = {};
  button.append(tile.picture);
  const text = make("div", null, "text");
  const [head, marks] = [make("div", null, "head"), make("div", null, "marks")];
  for (const [place, parts] of [[head, ["name", "health"]], [text, ["trainee", "task", "step"]], [marks, ["score", "alarms"]]]) {
    for (const part of parts) {
      tile.parts[part] = make("span", null, part);
      place.append(tile.parts[part]);
    }
  }
  text.prepend(head);
  button.append(text, marks);
  button.addEventListener("click", () => enlarge(name));
  tile.parts.name.textContent = name;
  stations.set(name, tile);
  const after = [...stations.keys()].filter((other) => other !== name && other.localeCompare(name, undefined, { numeric: true }) > 0);
  after.sort((a, b) => a.localeCompare(b, undefined, { numeric: true }));
  byId("tiles").insertBefore(button, after.length ? stations.get(after[0]).button : null);
  return tile;
}

// Condition of a station: a word, and a class for its colour.
function condition(tile) {
  const told = tile.told;
  if (!told?.present) return ["away", "away"];
  if (Date.now() - tile.heard > SILENT_MS) return ["silent", "bad"];
  const state = told.state;
  if (!state || !state.running) return ["waiting", "away"];
  if (state.paused) return ["paused", "away"];
  if (state.device === "lost" || state.device === "stale") return [state.device, "bad", "device"];
  if (state.realtime === false) return ["notRealtime", "warn"];
  if (state.realtime === null) return ["running", "away"];
  return ["realtime", "good"];
}

function conditionText(tile) {
  const [word, , before] = condition(tile);
  return before ? `${say(before)}: ${say(word)}` : say(word);
}

function show(tile) {
  const state = tile.told?.state;
  const task = state?.task;
  const [, kind] = condition(tile);
  tile.button.dataset.kind = kind;
  tile.parts.health.textContent = conditionText(tile);
  tile.parts.trainee.textContent = state?.trainee ?? "";
  tile.parts.task.textContent = task ? `${clock(task.time_s)} ${both(task.title)}` : "";
  tile.parts.step.textContent = task ? both(task.end ?? task.step) : "";
  const score = task?.score;
  tile.parts.score.textContent = score === null || score === undefined ? "" : `${say("score")} ${score.toFixed(0)}`;
  const alarms = state?.alarms ?? 0;
  tile.parts.alarms.textContent = alarms ? `${alarms} ⚠` : "";
  tile.parts.alarms.title = say("alarms");
  if (large === tile.name) showLarge();
}

function take(told) {
  const tile = tileOf(told.name);
  const last = { operation: tile.told?.state?.operation, alarms: tile.told?.state?.alarms ?? 0 };
  tile.told = told;
  tile.heard = Date.now();
  const state = told.state;
  const isNew = state && state.alarms > (last.operation === state.operation ? last.alarms : 0);
  if (isNew && last.operation !== undefined) {
    tile.button.classList.remove("flash");
    void tile.button.offsetWidth; // begins the animation anew
    tile.button.classList.add("flash");
    clearTimeout(tile.calm);
    tile.calm = setTimeout(() => tile.button.classList.remove("flash"), FLASH_MS);
  }
  if (large === told.name && isNew) askAlarms();
  show(tile);
}

function remove(name) {
  const tile = stations.get(name);
  if (!tile) return;
  tile.button.remove();
  stations.delete(name);
  if (large === name) enlarge(null);
}

function showPicture(bytes) {
  const head = new Uint8Array(bytes, 0, 2);
  const name = new TextDecoder().decode(new Uint8Array(bytes, 2, head[1]));
  const url = URL.createObjectURL(new Blob([new Uint8Array(bytes, 2 + head[1])], { type: "image/jpeg" }));
  const isLarge = head[0] === "v".charCodeAt(0);
  const image = isLarge ? byId("large-picture") : stations.get(name)?.picture;
  if (!image || (isLarge && large !== name)) {
    URL.revokeObjectURL(url);
    return;
  }
  image.addEventListener("load", () => URL.revokeObjectURL(url), { once: true });
  image.addEventListener("error", () => URL.revokeObjectURL(url), { once: true });
  image.src = url;
  if (isLarge) window.shownPictures = (window.shownPictures ?? 0) + 1;
}

function enlarge(name) {
  large = name;
  byId("large").hidden = name === null;
  byId("large-picture").removeAttribute("src");
  byId("remark-outcome").textContent = "";
  byId("alarms").replaceChildren();
  send({ enlarge: name });
  for (const tile of stations.values()) tile.button.setAttribute("aria-pressed", tile.name === name);
  if (name !== null) {
    showLarge();
    askAlarms();
  }
}

function showLarge() {
  const tile = stations.get(large);
  const state = tile?.told?.state;
  const task = state?.task;
  byId("large-name").textContent = large;
  const facts = [["health", tile ? conditionText(tile) : ""]];
  if (state?.trainee) facts.push(["trainee", state.trainee]);
  if (task) {
    facts.push(["task", `${both(task.title)} (${say(`help-${task.difficulty}`)})`], ["time", clock(task.time_s)]);
    facts.push(["step", `${both(task.end ?? task.step)} (${task.steps_done}/${task.steps})`]);
    if (task.score !== null) facts.push(["score", task.score.toFixed(1)]);
  }
  if (state) facts.push(["missed", String(state.missed)]);
  if (tile?.told?.lost_alarms) facts.push(["lostAlarms", String(tile.told.lost_alarms)]);
  byId("large-facts").replaceChildren(...facts.flatMap(([word, text]) => [make("dt", say(word)), make("dd", text)]));
}

async function askAlarms() {
  const name = large;
  const answer = await fetch(`/api/alarms?name=${encodeURIComponent(name)}`);
  if (!answer.ok || large !== name) return;
  const lines = (await answer.json()).map((it) => {
    const at = new Date(it.at_unix_ms).toLocaleTimeString(LANGUAGE);
    return make("li", `${at} · ${clock(it.at_s)} · ${both(it.text)}${it.trainee ? ` · ${it.trainee}` : ""}`);
  });
  byId("alarms").replaceChildren(...(lines.length ? lines : [make("li", say("noAlarms"))]));
}

function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function summarise() {
  let present = 0;
  for (const tile of stations.values()) {
    if (tile.told?.present) present += 1;
    show(tile);
  }
  const isOpen = socket?.readyState === WebSocket.OPEN;
  byId("summary").textContent = isOpen ? `${present} ${say("present")} ${stations.size} ${say("connected")}` : say("offline");
}

function connect() {
  socket = new WebSocket(`wss://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.addEventListener("open", () => {
    if (large !== null) send({ enlarge: large });
  });
  socket.addEventListener("message", (event) => {
    if (event.data instanceof ArrayBuffer) return showPicture(event.data);
    const told = JSON.parse(event.data);
    if (told.remark) {
      byId("remark-outcome").textContent = say(told.remark.outcome);
      return;
    }
    for (const name of told.gone) remove(name);
    for (const state of told.states) take(state);
  });
  socket.addEventListener("close", async () => {
    // A login that has ended leads back to its page; a centre that is away is tried again.
    const answer = await fetch("/api/alarms?name=").catch(() => null);
    if (answer?.status === 401) location.href = "/login";
    else setTimeout(connect, 1000);
  });
}

byId("close").addEventListener("click", () => enlarge(null));
byId("remark").addEventListener("submit", (event) => {
  event.preventDefault();
  const text = byId("remark-text").value.trim();
  if (!text || large === null) return;
  send({ remark: { station: large, text } });
  byId("remark-text").value = "";
  byId("remark-outcome").textContent = "…";
});
function turnTo(shown) {
  for (const name of ["stations", "results"]) {
    byId(name).hidden = name !== shown;
    byId(`show-${name}`).setAttribute("aria-pressed", name === shown);
  }
  if (shown === "results") showPeople();
}
byId("show-stations").addEventListener("click", () => turnTo("stations"));
byId("show-results").addEventListener("click", () => turnTo("results"));
setInterval(summarise, 500);
connect();
