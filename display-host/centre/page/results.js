"use strict";
// People, their sessions, and a learning curve for each task.
const SVG = "http://www.w3.org/2000/svg";

function draw(kind, values) {
  const element = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(values)) element.setAttribute(name, value);
  return element;
}

async function ask(path) {
  const answer = await fetch(path);
  if (answer.status === 403) throw new Error(say("forbidden"));
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}

async function showPeople() {
  const list = document.getElementById("people");
  document.getElementById("person").replaceChildren();
  try {
    const people = await ask("/api/people");
    const buttons = people.map((person) => {
      const button = make("button", `${person.name} · ${person.sessions} ${say("sessions")}`);
      button.addEventListener("click", () => showPerson(person.name));
      return button;
    });
    list.replaceChildren(...(buttons.length ? buttons : [make("p", say("nobody"))]));
  } catch (problem) {
    list.replaceChildren(make("p", problem.message));
  }
}

// Score against the number of the session. Those of a scripted hand say nothing about the person.
function curve(sessions) {
  const width = 480, height = 200, left = 36, bottom = 24, top = 8;
  const svg = draw("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", class: "curve" });
  svg.append(draw("title", {}));
  svg.firstChild.textContent = `${say("score")}: ${sessions.map((it) => it.score.toFixed(0)).join(", ")}`;
  const x = (at) => left + ((width - left - 12) * (at + 0.5)) / sessions.length;
  const y = (score) => top + ((height - top - bottom) * (100 - score)) / 100;
  for (const score of [0, 50, 100]) {
    svg.append(draw("line", { x1: left, x2: width - 6, y1: y(score), y2: y(score), class: "grid" }));
    const label = draw("text", { x: left - 6, y: y(score) + 4, "text-anchor": "end" });
    label.textContent = score;
    svg.append(label);
  }
  const points = sessions.map((it, at) => `${x(at)},${y(it.score)}`);
  svg.append(draw("polyline", { points: points.join(" "), class: "course" }));
  sessions.forEach((it, at) => {
    const dot = draw("circle", { cx: x(at), cy: y(it.score), r: 4, class: it.outcome === "passed" ? "passed" : "other" });
    svg.append(dot);
    if (sessions.length <= 20) {
      const label = draw("text", { x: x(at), y: height - 6, "text-anchor": "middle" });
      label.textContent = at + 1;
      svg.append(label);
    }
  });
  return svg;
}

async function showPerson(name) {
  const place = document.getElementById("person");
  let sessions;
  try {
    sessions = await ask(`/api/sessions?name=${encodeURIComponent(name)}`);
  } catch (problem) {
    place.replaceChildren(make("p", problem.message));
    return;
  }
  const parts = [make("h2", name)];
  const own = sessions.filter((it) => it.hand === "person");
  for (const task of new Set(own.map((it) => it.task))) {
    parts.push(make("h3", say(task)), curve(own.filter((it) => it.task === task)));
  }
  const table = make("table");
  const head = make("tr");
  for (const word of ["date", "task", "difficulty", "outcome", "score", "alarms"]) head.append(make("th", say(word)));
  table.append(head);
  for (const it of [...sessions].reverse()) {
    const row = make("tr");
    const at = new Date(it.began_unix_s * 1000).toLocaleString(LANGUAGE, { dateStyle: "medium", timeStyle: "short" });
    const hand = it.hand === "scripted" ? ` (${say("scripted")})` : "";
    for (const text of [at, say(it.task), say(`help-${it.difficulty}`), say(it.outcome) + hand, it.score.toFixed(1), it.alarms]) {
      row.append(make("td", text));
    }
    table.append(row);
  }
  parts.push(table);
  place.replaceChildren(...parts);
}
