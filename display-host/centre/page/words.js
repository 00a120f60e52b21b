"use strict";
// Texts of the page. What stations say comes in both languages.
const LANGUAGE = navigator.language.startsWith("de") ? "de" : "en";
const WORDS = {
  en: {
    name: "Name", password: "Password", login: "Log in", logout: "Log out",
    wrong: "The name or the password is wrong.",
    wait: "Too many tries. Wait a minute.",
    stations: "Stations", results: "Results", close: "Close", alarms: "Alarms", send: "Send",
    remark: "Remark to the trainee, read in the debrief", done: "The remark is recorded.",
    away: "not connected", silent: "no answer", waiting: "no operation", paused: "paused",
    notRealtime: "not realtime", realtime: "realtime", running: "running", device: "device", lost: "lost", stale: "silent",
    score: "Score", step: "Step", task: "Task", trainee: "Trainee", time: "Time", health: "Machine",
    missed: "Missed ticks", alarm: "alarm", noAlarms: "none", offline: "The centre is not reached.",
    present: "of", connected: "connected", nobody: "No results yet.", difficulty: "Help", date: "Date",
    outcome: "Outcome", sessions: "sessions", forbidden: "You may see your stations only.",
    passed: "passed", failed: "failed", aborted: "not completed", practised: "practice completed", "cut-short": "cut short",
    scripted: "scripted hand", lostAlarms: "Alarms lost on the way",
    "help-beginner": "beginner", "help-trainee": "trainee", "help-exam": "exam",
    clamp: "Clamp", cut: "Cut", identify: "Identify", scope: "Endoscope", basics: "First steps",
    disconnect: "Disconnect", full: "The whole operation", free: "Free practice", phantom: "Drills on a phantom",
  },
  de: {
    name: "Name", password: "Passwort", login: "Anmelden", logout: "Abmelden",
    wrong: "Name oder Passwort ist falsch.",
    wait: "Zu viele Versuche. Warten Sie eine Minute.",
    stations: "Stationen", results: "Ergebnisse", close: "Schließen", alarms: "Fehler", send: "Senden",
    remark: "Bemerkung für die Nachbesprechung", done: "Die Bemerkung ist aufgezeichnet.",
    away: "nicht verbunden", silent: "keine Antwort", waiting: "keine Operation", paused: "Pause",
    notRealtime: "nicht Echtzeit", realtime: "Echtzeit", running: "läuft", device: "Gerät", lost: "verloren", stale: "stumm",
    score: "Punkte", step: "Schritt", task: "Aufgabe", trainee: "Übende Person", time: "Zeit", health: "Rechner",
    missed: "Ausgefallene Takte", alarm: "Fehler", noAlarms: "keine", offline: "Die Zentrale ist nicht erreichbar.",
    present: "von", connected: "verbunden", nobody: "Noch keine Ergebnisse.", difficulty: "Hilfe", date: "Datum",
    outcome: "Ergebnis", sessions: "Übungen", forbidden: "Sie dürfen nur Ihre Stationen sehen.",
    passed: "bestanden", failed: "nicht bestanden", aborted: "nicht abgeschlossen", practised: "Übung beendet",
    "cut-short": "vorzeitig beendet",
    scripted: "Skript", lostAlarms: "Unterwegs verlorene Fehler",
    "help-beginner": "Anfänger", "help-trainee": "Fortgeschrittene", "help-exam": "Prüfung",
    clamp: "Clippen", cut: "Durchtrennen", identify: "Darstellen", scope: "Endoskop führen", basics: "Erste Schritte",
    disconnect: "Ablösen", full: "Die ganze Operation", free: "Freies Üben", phantom: "Übungen am Phantom",
  },
};

function say(word) {
  return WORDS[LANGUAGE][word] ?? word;
}

// An element with text, never with markup: stations and people choose names.
function make(kind, text, className) {
  const element = document.createElement(kind);
  if (text !== undefined && text !== null) element.textContent = text;
  if (className) element.className = className;
  return element;
}

document.documentElement.lang = LANGUAGE;
for (const element of document.querySelectorAll("[data-word]")) element.textContent = say(element.dataset.word);
const problem = document.getElementById("problem");
const asked = location.search.slice(1);
if (problem && (asked === "wrong" || asked === "wait")) problem.textContent = say(asked);
