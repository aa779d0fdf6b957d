// What the operator's page says, in two languages. What the station says itself is English: its known
// sentences have a translation, and others (reasons, with their figures) stay as the verdict file has them.

export const WORDS = {
  en: {
    READY: "READY", RUN: "RUN", PASS: "PASS", FAIL: "FAIL", INVALID: "INVALID", gone: "NO CONNECTION",
    "": "STARTING", goneNext: "What was shown may be old. See to the station.", number: "Serial number",
    begin: "Begin", keys: "Keys", last: "Last motors", yield: "First-pass yield", counts: "This shift",
    again: "Tested again", ignored: "Scans ignored", golden: "Golden motor", anyGood: "A good motor",
    due: "due now", dueIn: (n) => `due in ${n} inspections`, of: (n) => `of ${n}`,
    soundOn: "Sound on", soundOff: "Sound off", other: "Deutsch", current: "current", speed: "speed",
    erase: "Erase",
  },
  de: {
    READY: "BEREIT", RUN: "MESSUNG", PASS: "GUT", FAIL: "SCHLECHT", INVALID: "UNGÜLTIG",
    gone: "KEINE VERBINDUNG", "": "BEGINN", goneNext: "Die Anzeige kann alt sein. Nach der Station sehen.",
    number: "Seriennummer", begin: "Start", keys: "Tasten", last: "Letzte Motoren",
    yield: "Gut im ersten Test", counts: "Diese Schicht", again: "Erneut geprüft",
    ignored: "Scans übergangen", golden: "Referenzmotor", anyGood: "Ein guter Motor", due: "jetzt fällig",
    dueIn: (n) => `fällig in ${n} Prüfungen`, of: (n) => `von ${n}`, soundOn: "Ton an",
    soundOff: "Ton aus", other: "English", current: "Strom", speed: "Drehzahl", erase: "Löschen",
  },
};

const GERMAN = {
  "Put a motor in and scan its serial number.": "Motor einlegen und Seriennummer scannen.",
  "Keep your hands off the motor: it turns.": "Hände weg vom Motor: er dreht sich.",
  "Put the motor with the good ones. Scan the next serial number.":
    "Motor zu den guten legen. Nächste Seriennummer scannen.",
  "Put the motor with the rejects. Scan the next serial number.":
    "Motor zum Ausschuss legen. Nächste Seriennummer scannen.",
  "Leave the motor in the rig, see to it, and scan the same number again.":
    "Motor eingelegt lassen, Ursache beheben, dieselbe Nummer erneut scannen.",
  "Call maintenance.": "Instandhaltung rufen.",
  "MARGINAL: within its limits, but not by the guard band":
    "GRENZWERTIG: in den Grenzen, aber nicht um den Sicherheitsabstand",
  "scan a serial number, or type it and press Enter": "Seriennummer scannen, oder tippen und Enter drücken",
};

export const translated = (text, language) => (language === "de" ? GERMAN[text] ?? text : text);

export function preferred() {
  const kept = localStorage.getItem("motorid language");
  return kept ?? (navigator.language.startsWith("de") ? "de" : "en");
}
