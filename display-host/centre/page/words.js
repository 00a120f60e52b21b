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
    notRealtime: "not realtime", realtime: "realtime", device: "device", lost: "lost", stale: "silent",
    score: "Score", step: "Step", task: "Task", trainee: "Trainee", time: "Time", health: "Machine",
    missed: "missed periods", alarm: "alarm", noAlarms: "none", offline: "The centre is not reached.",
    present: "of", connected: "connected", nobody: "No results yet.", difficulty: "Help", date: "Date",
    outcome: "Outcome", sessions: "sessions", forbidden: "You may see your stations only.",
    passed: "passed", failed: "failed", aborted: "aborted", practised: "practised", "cut-short": "cut short",
    scripted: "scripted hand", lostAlarms: "alarms lost on the way",
    exam: "exam", beginner: "beginner", clamp: "Clip duct and artery", cut: "Divide duct and artery",
    identify: "Critical view of safety", scope: "Endoscope drill", basics: "First steps",
    disconnect: "Free the gallbladder", full: "Whole procedure", free: "Free practice",
  },
  de: {
    name: "Name", password: "Passwort", login: "Anmelden", logout: "Abmelden",
    wrong: "Name oder Passwort ist falsch.",
    wait: "Zu viele Versuche. Warten Sie eine Minute.",
    stations: "Stationen", results: "Ergebnisse", close: "Schließen", alarms: "Fehler", send: "Senden",
    remark: "Bemerkung für die Nachbesprechung", done: "Die Bemerkung ist aufgezeichnet.",
    away: "nicht verbunden", silent: "keine Antwort", waiting: "keine Operation", paused: "Pause",
    notRealtime: "nicht Echtzeit", realtime: "Echtzeit", device: "Gerät", lost: "verloren", stale: "stumm",
    score: "Punkte", step: "Schritt", task: "Aufgabe", trainee: "Übende Person", time: "Zeit", health: "Rechner",
    missed: "ausgefallene Takte", alarm: "Fehler", noAlarms: "keine", offline: "Die Zentrale ist nicht erreichbar.",
    present: "von", connected: "verbunden", nobody: "Noch keine Ergebnisse.", difficulty: "Hilfe", date: "Datum",
    outcome: "Ergebnis", sessions: "Übungen", forbidden: "Sie dürfen nur Ihre Stationen sehen.",
    passed: "bestanden", failed: "nicht bestanden", aborted: "abgebrochen", practised: "geübt",
    "cut-short": "vorzeitig beendet",
    scripted: "Skript", lostAlarms: "unterwegs verlorene Fehler",
    exam: "Prüfung", beginner: "Anfänger", clamp: "Gang und Arterie clippen", cut: "Gang und Arterie durchtrennen",
    identify: "Critical View of Safety", scope: "Endoskopübung", basics: "Erste Schritte",
    disconnect: "Gallenblase auslösen", full: "Ganzer Eingriff", free: "Freies Üben",
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
