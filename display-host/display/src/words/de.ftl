# Texte der Oberfläche auf Deutsch. Zahlen übergibt das Programm als gerundeten Text.

## Aufgaben
task-identify = Darstellen: Ductus cysticus und Arteria cystica freilegen
task-clamp = Clippen: Ductus cysticus und Arteria cystica verschließen
task-cut = Durchtrennen: beide zwischen den Clips durchtrennen
task-disconnect = Ablösen: die Gallenblase von der Leber trennen
task-full = Die ganze Operation
task-free = Freies Üben
task-none = Drücken, greifen und ziehen: die Organe kennenlernen
task-scope = Endoskop: die Organe der Reihe nach zeigen

## Instrumente
instrument-0 = Fasszange
instrument-1 = Hakenelektrode
instrument-2 = Schere
instrument-3 = Clipzange
instrument-unknown = Unbekanntes Instrument

device-haptic = Haptisches Gerät
device-tracker = Endoskop-Tracker
device-pedal = Fußschalter

## Während der Aufgabe
hud-clips = { $count } Clips übrig
hud-pedal-none = Fußschalter: aus
hud-pedal-cut = Fußschalter: Schneiden
hud-pedal-coagulate = Fußschalter: Koagulieren
hud-pedal-both = Beide Pedale gedrückt: kein Strom
hud-camera-held = Kamera gesperrt
hud-alarm = Alarm: { $text }
hud-hint = Als Nächstes: { $text }

## Pause
pause-title = Pause
pause-go-on = Weiter (P)
pause-again = Neu beginnen (R)
pause-end = Beenden (Esc)
pause-note = Während der Pause ist die Kraft ausgeschaltet.

## Einstellungen
settings = Einstellungen (O)
settings-title = Einstellungen
settings-language = Sprache
settings-text = Schriftgröße
settings-sound = Ton
settings-sound-on = an
settings-sound-off = aus
settings-screen = Vollbild (F11)
settings-close = Zurück (Esc)

## Wiedergabe
replay-at = { $at } von { $length }
replay-slider = Position in der Sitzung
replay-step = { $step } s
replay-speed = { $speed }×
replay-seeks = Von { $at } nach { $to } …
replay-free = Freie Kamera (C)
replay-free-help = Bild ziehen: umsehen, Mausrad: zoomen. Pfeiltasten: 1 s, Bild auf und ab: 10 s, Pos1: zum Anfang.

## Die Aufzeichnung
recording-on = Aufzeichnung läuft, { $megabytes } MB
recording-waits = Aufzeichnung: Datenträger voll oder nicht erreichbar, { $megabytes } MB warten; bitte Platz schaffen
recording-hangs = Aufzeichnung: der Datenträger reagiert seit einigen Sekunden nicht; bitte prüfen
recording-gap = Aufzeichnung läuft, aber { $missing } Takte fehlen
recording-events = Aufzeichnung läuft, aber { $missing } Ereignisse fehlen
recording-ended = Aufzeichnung beendet: der Datenträger war zu lange voll
recording-alarm = der Datenträger nimmt die Aufzeichnung nicht an; die Leiste sagt mehr

## Alarme
alarm-touched = fest gedrückt: { $organ }
alarm-burnt = verbrannt: { $organ }
alarm-cut = geschnitten: { $organ }
alarm-torn = eingerissen: { $organ }
alarm-perforated = perforiert: { $organ }
alarm-crushed = gequetscht: { $organ }; lockerer greifen
alarm-clip-lost = Clip ohne Gewebe geschlossen
alarm-clip-misplaced = Clip falsch gesetzt: { $organ }
alarm-too-early = vor Erreichen des Critical View geclippt: { $organ }
alarm-unclamped = offen, nicht durch Clips verschlossen: { $organ }

## Stand einer Aufgabe
task-time = Zeit: { $time }
task-score = { $score } von 100 Punkten
task-done = { $step } (erledigt)
task-to-do = { $step } (offen)
task-hint = Hinweis: { $text }
task-alarm = Alarm { $number }: { $text }
task-end = { $outcome }: { $reasons }
outcome-running = Läuft
outcome-passed = Bestanden
outcome-failed = Nicht bestanden
outcome-aborted = Nicht abgeschlossen
outcome-practised = Übung beendet
hud-end = Zum Bericht (Esc)

## Die Leiste
quit = Beenden (Esc)
alarm = Alarm: { $text }
alarm-acknowledge = Quittieren (A)
waiting-other-scene = Die Steuerung verwendet eine andere Szene.
    Diese Anzeige zeigt „{ $scene }“: bitte beide mit derselben Szene starten.
waiting-picture = Bild wird vorbereitet
waiting-controller = Warten auf die Steuerung der Station „{ $station }“.
    Starten mit: calot rt
controller-paused = Steuerung: Pause
controller-live = Steuerung: läuft
controller-waiting = Steuerung: noch nicht gestartet
controller-silent = Steuerung: keine Antwort seit { $seconds } s
controller-other-scene = Steuerung: andere Szene
device-unknown = { $device }: unbekannt
device-absent = { $device }: nicht angeschlossen
device-live = { $device }: bereit, letzter Messwert vor { $age } ms
device-stale = { $device }: verzögert, letzter Messwert vor { $age } ms
device-lost = { $device }: Verbindung verloren; bitte neu einstecken
device-odd = { $device }: unbekannter Status { $status }
device-bad = { $state }, { $count } Messwerte fehlerhaft oder verloren
instrument = Instrument
scope = Endoskop: { $angle }°, Lichtkabel um { $turned }° gedreht, Fokus { $focus } mm
scope-next = Nächstes Endoskop (S)
scope-left = Nach links drehen ([)
scope-right = Nach rechts drehen (])
scope-nearer = Fokus näher (-)
scope-farther = Fokus weiter (+)
scope-wipe = Optik reinigen (W)
scope-dirty = Optik: beschlagen oder verrußt, bitte reinigen
scope-held = Kamera: über Fußschalter gesperrt
smoke-draw-off = Rauch absaugen (D)
smoke-close = Ventil schließen (D)
smoke-drawn-off = Rauch: wird durch den Trokar abgesaugt
smoke-gathers = Rauch: behindert die Sicht, bitte absaugen
switch-pause = Pause (P)
switch-go-on = Weiter (P)
switch-reset = Organe zurücksetzen (R)
switch-engineering = Technische Ansicht (E)
switch-hand = Instrument mit Maus und Tastatur führen (M)
switch-hand-off = Instrument loslassen (M)
switch-force = Kraft einschalten (F)
switch-force-off = Kraft ausschalten (F)
help = Maus oder Pfeile: bewegen   Rad oder Bild-Tasten: vor, zurück   Links oder Leertaste: Branchen   Rechts oder V: koagulieren   C: schneiden   , und .: drehen
    Mittlere Taste oder Strg+Pfeile: Endoskop   L: Kamera sperren   Umschalt: langsam   M oder Esc: loslassen
force = Kraft auf die Hand: { $force } N
force-cut = Kraft auf die Hand: { $force } N, ausgeschaltet
picture = Bild: { $rate } pro Sekunde, { $age } ms nach der Handbewegung übergeben
picture-alt = Endoskopbild
quality = Qualität: Stufe { $tier } von { $tiers } (1 ist die beste)
graphics = Grafik: { $ms } ms pro Bild
pass-skinning = Oberflächen
pass-shadow = Schatten
pass-scene = Organe und Instrumente
pass-exposure = Belichtung
pass-glare = Überstrahlung
pass-lens = Optik
pass-time = { $name }: { $ms } ms

## Takte und Sicherheitskette
ticks-none = Takte: noch keine erfasst
ticks-realtime = Echtzeit: ja
ticks-lacks = Keine Echtzeit: es fehlt { $what }
ticks-rate = Takte: { $rate } pro Sekunde
ticks-counts = Ausgefallen { $missed }, verspätet { $late }, Speicheranforderungen { $allocations }, Seitenfehler { $faults }
ticks-wake = Weckverzögerung: 99 % unter { $most } µs, längste { $worst } µs
ticks-tick = Takt: 99 % unter { $most } µs, längster { $worst } µs
ticks-wake-name = Weckverzögerung
ticks-tick-name = Dauer eines Takts
ticks-bars = { $name }, 1 µs bis 33 ms, jeder Balken doppelt so breit wie der vorige
lacks-fifo = SCHED_FIFO
lacks-locked = gesperrter Speicher
lacks-core = ein eigener Kern
gates = Sicherheitskette: { $count } Eingriffe
gate = { $count } × { $what }
gate-bad-sample = Messwerte verworfen: ungültig oder außerhalb des Arbeitsraums
gate-speed-trip = abgeschaltet: der Griff bewegte sich zu schnell
gate-bad-force = keine Kraft: ungültiger Wert
gate-not-enabled = keine Kraft: nicht eingeschaltet
gate-lost-device = abgeschaltet: die Verbindung zum Gerät war unterbrochen
gate-stale-device = abgesenkt: das Gerät war verzögert
gate-ramped = angehoben: nach dem Einschalten oder in einer Pause
gate-stiffness-capped = weicher gestellt: so steif, wie das Gerät stabil darstellen kann
gate-damped = gedämpft: der Kontakt führte der Hand Energie zu
gate-clamped = auf die Höchstkraft des Geräts begrenzt
gate-thermal-limited = verringert: die Motoren sind warm
gate-slewed = geglättet: die Kraft änderte sich zu schnell

## Störungen, die Kraft oder Strom abschalten
fault-no-number = die Kraft war ungültig: sie ist ausgeschaltet
fault-late = das haptische Gerät ist verzögert: die Kraft wird abgesenkt
fault-gone = das haptische Gerät ist getrennt: die Kraft ist aus
fault-fast = der Griff bewegte sich zu schnell: die Kraft bleibt aus, bis sie eingeschaltet wird (F)
fault-silent = das haptische Gerät sendet keinen gültigen Messwert: die Kraft ist aus
fault-frozen = das haptische Gerät wiederholt eine Lage: die Kraft ist aus
fault-clock = die Uhr des haptischen Geräts geht falsch: die Kraft ist aus
fault-bundles = die Messwerte des haptischen Geräts kommen in Bündeln: die Kraft ist aus
fault-deaf = das haptische Gerät bestätigt keine Kraft: die Kraft ist aus
fault-pedal = das Fußpedal ist getrennt: es gilt als losgelassen
fault-held = ein Pedal ist gedrückt: einmal loslassen
fault-device = das haptische Gerät meldet einen Fehler: die Kraft ist aus
fault-watchdog = das haptische Gerät bekam nicht rechtzeitig eine Kraft und hat sie weggenommen
fault-both = Schneiden und Koagulieren zugleich gedrückt: kein Strom
unrest-falls = fällt: { $organ }; die Szene hält dieses Organ nicht
unrest-buried = das Instrument steckt in: { $organ }; ziehen Sie es heraus
unrest-shakes = zittert: { $organ }; das liegt an der Szene, nicht an Ihnen

## Abgelehnte Befehle
command-not-done = Nicht möglich: { $what }. { $why }
command-pause = anhalten oder fortsetzen
command-start = Aufgabe neu beginnen
command-reset = Organe zurücksetzen
command-force = Kraft ein- oder ausschalten
command-instrument = Instrument wechseln
command-seek = zu einem anderen Zeitpunkt springen
command-speed = Geschwindigkeit ändern
command-other = der Befehl
refused-unknown = Die Steuerung kennt diesen Befehl nicht; sie hat vielleicht eine andere Version.
refused-range = Das bietet die Steuerung nicht.
refused-busy = Die Steuerung ist ausgelastet: bitte noch einmal versuchen.
refused-otherwise = Die Steuerung hat abgelehnt (Antwort { $answer }).
service-no-answer = Die Steuerung antwortet nicht: läuft die Station?
service-other-version = Auf dieser Station läuft ein Prozess einer anderen Version: bitte beenden.
hand-elsewhere = Der Experte oder eine andere Anzeige führt das Instrument. Bitte dort loslassen (M) oder abwarten.
hand-nobody = Kein simuliertes Instrument verfügbar: es gehört zu einem echten Gerät, oder die Station läuft nicht.

## Startfenster
launcher-start = Start
launcher-running = Operation
launcher-debrief = Nachbesprechung
launcher-questions = Fragebogen
launcher-sheet = Bewertungsbogen
launcher-failed = Operation nicht gestartet

## Start
start-title = Aufgabe wählen
start-begin = Beginnen (Eingabe)
start-watch = Dem Experten zusehen (W)
who-expert = Der Experte (ein automatischer Operateur)
start-trainee = Wer übt
start-nobody = Gast (ohne Speichern)
start-new-name = Neuer Name (N)
start-not-kept = Gast-Sitzungen werden nicht gespeichert: zum Speichern Namen wählen oder eingeben.
start-kept = Gespeichert in { $store }
start-task = Aufgabe
start-asks-identify = Das Calot-Dreieck und das untere Drittel der Gallenblase mit der Hakenelektrode freipräparieren, bis nur noch Ductus cysticus und Arteria cystica zur Gallenblase ziehen.
start-asks-clamp = Ductus cysticus und Arteria cystica mit genügend Clips in ausreichendem Abstand verschließen, sonst nichts clippen.
start-asks-cut = Ductus und Arterie mit der Schere durchtrennen, jeweils zwischen den Clips.
start-asks-disconnect = Die Gallenblase mit der Hakenelektrode aus dem Leberbett lösen, ohne Gallenblase oder Leber zu eröffnen.
start-asks-full = Alle vier Aufgaben der Reihe nach, von der ersten Berührung bis zur gelösten Gallenblase.
start-asks-free = Kein Ziel vorgegeben; alles wird gemessen.
start-asks-scope = Mit dem Endoskop ein Organ nach dem anderen zeigen, bei waagrechtem Horizont und ruhigem Bild.
start-own-sutures = Die Haltefäden der Gallenblase selbst setzen
start-difficulty = Hilfestellung
start-scope = Endoskop
start-scene = Szene
scene-triangle = Calot-Dreieck
scene-triangle-variant = Calot-Dreieck, anatomische Variante
scene-built-in = Leber und Gallenblase
start-devices = Geräte
start-emulated = Simuliert
start-by-file = Aus Stationsdatei
start-station-file = Stationsdatei
start-device-emulated = { $device }: simuliert
start-device-there = { $device }: { $path } angeschlossen
start-device-missing = { $device }: { $path } nicht gefunden. Bitte einstecken oder simulierte Geräte wählen
start-device-named = { $device }: { $path }, wird beim Start geprüft
start-hand = Mit M führen Sie das Instrument mit Maus und Tastatur; bis dahin ruht es.
start-nothing-plugged-in = Kein serielles Gerät und kein Fußschalter angeschlossen.
start-plugged-in = Angeschlossen: { $list }
start-no-file = Bitte eine Stationsdatei angeben oder simulierte Geräte wählen.

difficulty-beginner = Anfänger
difficulty-beginner-gives = Der nächste Schritt wird angezeigt, ebenso Alarme und Fortschritt.
difficulty-trainee = Fortgeschrittene
difficulty-trainee-gives = Alarme und Fortschritt werden angezeigt.
difficulty-exam = Prüfung
difficulty-exam-gives = Nur Zeit und Aufgabe werden angezeigt, Fehler erst am Ende.
start-no-folder = { $path }: { $problem }. Bitte einen anderen Ordner mit --sessions angeben.
start-no-process = Die Operation ließ sich nicht starten: { $problem }

## Der Speicher der Übenden, und Stationsdateien
store-no-home = Kein Benutzerordner gefunden: bitte die Speicherdatei mit --store angeben.
store-io = { $path }: { $problem }. Bitte eine andere Datei mit --store angeben.
store-missing = Unter { $path } gibt es noch keine Speicherdatei.
store-same = { $path } ist die Speicherdatei selbst und kann nicht mit sich vereint werden. Bitte eine andere Datei mit --store angeben.
store-foreign = { $path } ist keine Speicherdatei von Calot und blieb unverändert. Bitte eine andere Datei mit --store angeben.
store-version = { $path } ist eine Speicherdatei der Version { $problem } eines anderen Calot und blieb unverändert. Bitte jenes Calot verwenden oder eine andere Datei mit --store angeben.
store-damaged = { $path } ist beschädigt ({ $problem }) und blieb unverändert. Bitte eine Kopie einspielen, oder die Datei verschieben und neu beginnen.
store-busy = { $path } ist in Gebrauch: ein anderes Programm schreibt hinein. Bitte später noch einmal versuchen.
store-log = { $path } hat eine Protokolldatei ({ $problem }), die ein anderes Programm offen hält. Es wurde niemand gelöscht: bitte diese Programme beenden und noch einmal versuchen.
store-sqlite = { $path }, Datenbank: { $problem }
store-no-trainee = Im Speicher gibt es niemanden namens „{ $name }“.
store-no-session = Die Sitzung ist nicht im Speicher.
store-taken = Die Sitzung ist unter einem anderen Namen gespeichert.
store-forgotten = Die Sitzung gehört jemandem, der nach ihrem Beginn gelöscht wurde, und bleibt draußen. Eine neue Sitzung wird gespeichert.
store-value = { $value } liegt außerhalb des zulässigen Bereichs.
store-questions = Fragebogen: { $problem }
store-sheet = Bewertungsbogen: { $problem }
store-rated = „{ $rater }“ hat den Bogen „{ $sheet }“ für die Sitzung { $session } schon ausgefüllt, und er bleibt.
store-alike = „{ $name }“ sieht aus wie „{ $known }“ im Speicher. Bitte jenen Namen wählen oder einen, der nicht verwechselt werden kann.
store-name = { $name } ist als Name nicht möglich: bitte 1 bis 64 sichtbare Zeichen eingeben.
station-file-none = { $path } ist keine Stationsdatei, sondern ein Ordner, eine Pipe oder ein Gerät. Bitte eine Textdatei (TOML) angeben, die die Geräte aufführt.
station-file-unread = { $path } lässt sich nicht lesen: { $problem }
station-file-wrong = { $path }, Zeile { $line }: { $problem }

## Während operiert wird
running-title = Die Operation läuft
running-ending = Die Operation wird beendet
running-note = Die Operation hat ein eigenes Fenster; dort beendet Esc sie. Danach erscheint hier die Nachbesprechung.
running-stop = Beenden (S)
running-stop-at-once = Sofort beenden, ohne Bericht (S)

## Nichts zu besprechen
failed-title = Die Operation fand nicht statt
failed-status = Die Station wurde beendet: { $status }
failed-note = Dies sind ihre letzten Meldungen. Bitte das Problem beheben oder die Auswahl ändern.
failed-again = Noch einmal versuchen (Eingabe)
failed-emulated = Mit simulierten Geräten versuchen
failed-quit = Beenden
failed-code = mit Code { $number }
failed-signal = durch Signal { $number }
failed-recorded = Die Aufzeichnung ist erhalten: calot store add NAME '{ $path }'

## Nachbesprechung
debrief-again = Noch einmal (Eingabe)
debrief-own-turn = Jetzt Sie (Eingabe)
debrief-another = Andere Aufgabe (Esc)
debrief-report = Ganzen Bericht öffnen (R)
debrief-questions = Fragebogen (Q)
debrief-sheet = Bewertungsbogen (I)
debrief-answered = Fragebogen: ausgefüllt
debrief-sheet-points = Bewertungsbogen: { $points } von 25
debrief-errors = Fehler
debrief-no-errors = Keine.
debrief-past = Frühere Sitzungen
debrief-no-past = Noch keine frühere Sitzung zum Vergleich.
debrief-metrics = Ergebnisse
debrief-report-opened = Der Bericht wurde geöffnet: { $path }
debrief-report-lies = Der Bericht liegt in { $path }; kein Programm hat ihn geöffnet ({ $problem }).
metric = Messgröße
metric-now = Aktuell
metric-rule = Zum Bestehen
metric-best = Bestwert
sheet-not-whole = Bitte alle fünf Punkte bewerten.

## Punkte von 1 bis 5
points-about = Name: { $name }
points-number = { $number } von { $of }
points-scale = 1: niedrigste Wertung. 5: höchste. Tasten 1 bis 5 drücken.
points-all = Alle Fragen sind beantwortet:
points-keep = Speichern (Eingabe)
points-previous = Vorige Frage (Rücktaste)
points-back = Zurück, ohne zu speichern (Esc)

question-anatomy = Wie realistisch ist die Anatomie?
question-triangle = Wie realistisch ist das Darstellen des Calot-Dreiecks?
question-interface = Wie realistisch ist das Bild?
question-instruments = Wie realistisch ist die Handhabung der Instrumente?
question-electric-dissection = Wie realistisch ist die elektrochirurgische Präparation?
question-removal = Wie realistisch ist das Auslösen der Gallenblase?
question-laparoscopy = Wie realistisch ist es im Vergleich zur konventionellen Laparoskopie?
question-force-quality = Wie gut ist die Kraftrückmeldung?
question-force-use = Wie nützlich ist die Kraftrückmeldung?
question-hand-eye = Wie nützlich ist es für das Training der Hand-Auge-Koordination?
question-both-hands = Wie nützlich ist es für das beidhändige Arbeiten?
question-notes-skills = Wie nützlich ist es für die Grundfertigkeiten der Chirurgie durch natürliche Körperöffnungen (NOTES)?
question-measures = Wie sehr vertrauen Sie den Leistungsmaßen?
question-other-coordination = Wie sicher sind Sie, dass sich die Hand-Auge-Koordination von der Technik mit zwei Zugängen unterscheidet?

goals-depth = Tiefenwahrnehmung: 1 verfehlt das Ziel und korrigiert langsam, 5 geht direkt zum Ziel
goals-hands = Beidhändigkeit: 1 nutzt nur eine Hand, 5 nutzt beide Hände für die beste Exposition
goals-efficiency = Effizienz: 1 unsicher, viele Versuche, 5 sicher, zügig und zielgerichtet
goals-tissue = Umgang mit Gewebe: 1 grob, reißt und verletzt, 5 schonend, ohne Verletzung
goals-autonomy = Selbstständigkeit: 1 auch unter Anleitung nicht fähig, 5 arbeitet selbstständig

## Maße
metric-score = Punkte
metric-time-s = Zeit
metric-gaps-s = Aufzeichnungslücken
metric-paused-s = Zeit in Pausen
metric-device-lost-s = Zeit ohne ein Gerät
metric-noise-mm = Rauschen des Griffs in Ruhe
metric-restarts = Neustarts
metric-lost-events = Verlorene Ereignisse
metric-path-m = Instrumentenweg
metric-scope-path-m = Endoskopweg
metric-movements = Instrumentenbewegungen
metric-scope-movements = Endoskopbewegungen
metric-economy = Bewegungsökonomie
metric-smoothness = Flüssigkeit der Bewegung
metric-scope-smoothness = Flüssigkeit des Endoskops
metric-both-moving = Beide Hände in Bewegung
metric-idle-s = Ruhezeit
metric-force-max-n = Größte Kraft
metric-force-mean-n = Mittlere Kraft
metric-force-p95-n = Kraft, 95. Perzentil
metric-force-saturated-s = Zeit an der Kraftgrenze
metric-cautery-on-s = Stromabgabe
metric-cautery-air-s = Strom ohne Kontakt
metric-burn-wrong-j = Energie in geschützte Strukturen
metric-burn-liver-j = Energie in die Leber
metric-burn-gallbladder-j = Energie in die Gallenblase
metric-burn-duct-j = Energie in Gänge
metric-burn-vessel-j = Energie in Arterien
metric-burn-target-j = Energie in Fett und Bindegewebe
metric-touches = Geschützte Strukturen berührt
metric-touches-wrong = Fester Druck auf geschützte Strukturen
metric-burns-wrong = Geschützte Strukturen verbrannt
metric-cuts-wrong = Geschützte Strukturen geschnitten
metric-clips-used = Clips gesetzt
metric-clips-lost = Clips verloren
metric-clips-misplaced = Clips falsch gesetzt
metric-clips-duct = Clips auf dem Ductus cysticus
metric-clips-artery = Clips auf der Arteria cystica
metric-clip-spacing-mm = Kleinster Clipabstand
metric-cuts-one-sided = Außerhalb der Clips durchtrennt
metric-unclamped = Nicht durch Clips verschlossen
metric-injuries = Verletzungen
metric-blood-ml = Blutverlust
metric-bile-ml = Galleverlust
metric-perforations = Perforationen
metric-crushes = Gewebe gequetscht
metric-tears = Gewebe eingerissen
metric-slips = Gewebe abgerutscht
metric-out-of-view-s = Instrument außer Sicht
metric-scope-turn-deg = Endoskopdrehung
metric-scope-tilt-deg = Horizontneigung
metric-scope-sway-mm-s = Schwanken des gehaltenen Bildes
metric-exchanges = Instrumentenwechsel
metric-cvs-triangle = Calot-Dreieck freigelegt
metric-cvs-bed = Unteres Drittel freigelegt
metric-cvs-two = Nur zwei Strukturen
metric-views-held = Gehaltene Critical Views
metric-bed = Gallenblasenbett freigelegt
metric-alarms = Alarme

## Ausbilder
observe-title = Ausbildung: Station „{ $station }“
observe-no-task = Keine Aufgabe: freies Arbeiten ohne Bewertung
observe-difficulty = Hilfestellung: { $difficulty }
observe-metrics = Bisherige Messwerte
observe-alarms = Alarme
observe-no-alarms = Noch keine

## Die technische Ansicht
inside-counts = { $spheres } Kugeln, { $links } Federn, { $tetrahedra } Tetraeder; { $touched } Kugeln berührt
inside-asleep = Alle { $organs } Organe ruhen
inside-awake = Aktiv { $awake } von { $organs }: { $names }
inside-legend = Kugeln: grau ruhend, blau aktiv, weiß befestigt, orange berührt, rosa gegriffen.
    Türkis: Instrument; magenta: Position der Hand; gelb: Kraft, 2 cm pro Newton.

## Organe, nach ihren Namen in Szenen
organ-liver = Leber
organ-gallbladder = Gallenblase
organ-connective-tissue = Bindegewebe
organ-cystic-duct = Ductus cysticus
organ-bile-duct = Ductus choledochus
organ-hepatic-artery = Leberarterie
organ-cystic-artery = Arteria cystica
organ-fat = Fett
organ-stomach = Magen
organ-duodenum = Zwölffingerdarm
organ-intestine = Darm

## Texte der Bewertung: Schritte, Hinweise, Gründe
reason-not-done = nicht abgeschlossen: { $step }
hint-hold = { $step }. In der Bildmitte halten.
hint-take = { $step }. Dazu: { $instrument } ({ $key }).
hint-grasper = { $step }. Berühren, Pedal treten, den Faden zur Bauchwand führen, erneut treten.
hint-hook = { $step }. Einen Strang aufladen, abheben, dann kurz Strom geben.
hint-clip-applier = { $step }. Beide Branchen herumführen, die Spitzen im Blick behalten, dann schließen.
hint-scissors = { $step }. Beide Clips sehen, bevor sich die Scherenblätter schließen.
step-hang = Die Gallenblase mit { $count } Fäden aufhängen
step-triangle = Das Calot-Dreieck freilegen
step-lower-bed = Das untere Drittel der Gallenblase aus dem Bett lösen
step-view-front = Critical View von vorn einstellen und halten
step-view-behind = Critical View von hinten einstellen und halten
step-leave-whole = Ductus cysticus und Arteria cystica unversehrt lassen
step-clip = { $count } Clips setzen: { $organ }
step-divide = Zwischen Clips durchtrennen: { $organ }
step-free = Die Gallenblase von der Leber lösen
step-show = Zeigen: { $organ }
hold-on = Bild halten
hold-lacks-side = Von der anderen Seite auf Gang und Arterie blicken
hold-lacks-triangle = Mehr vom freigelegten Dreieck zeigen
hold-lacks-lower-bed = Mehr vom freigelegten Gallenblasenbett zeigen
hold-lacks-two = Ductus cysticus und Arteria cystica zeigen
hold-lacks-out-of-view = Mehr davon ins Bild bringen
hold-lacks-hidden = Davor liegt etwas
hold-lacks-aside = In die Bildmitte bringen
hold-lacks-small = Näher heran
hold-lacks-sway = Bild ruhig halten
hold-lacks-tilt = Horizont ausrichten
reason-unclamped = durch Clips nicht verschlossen: { $organ }
reason-injured-divided = durchtrennt: { $organ }
reason-injured-perforated = Wand eröffnet: { $organ }
reason-injured-burnt = stärker verbrannt, als die Wand übersteht: { $organ }
reason-not-whole = Ductus cysticus oder Arteria cystica ist nicht mehr unversehrt
reason-too-long = es dauerte länger als { $limit }
reason-too-little = { $metric }: { $value }, mindestens { $limit } erforderlich
reason-too-much = { $metric }: { $value }, erlaubt höchstens { $limit }
hint-instrument-grasper = Fasszange
hint-instrument-hook = Hakenelektrode
hint-instrument-clip-applier = Clipzange
hint-instrument-scissors = Schere

## Ein haptisches Gerät von Hand prüfen: `calot devices feel --window`
feel-part-move = Bewegen
feel-part-push = Drücken
feel-part-opening = Öffnen
feel-part-scale = Waage
feel-part-response = Antwort
feel-part-done = { $part }: fertig
feel-part-now = { $part }: { $number } von { $of }
feel-waiting = Die Prüfung beginnt …
feel-move = Den Griff { $mm } mm { $way } bewegen
feel-way-right = nach rechts
feel-way-left = nach links
feel-way-up = nach oben
feel-way-down = nach unten
feel-way-towards = zu sich her
feel-way-away = von sich weg
feel-move-note = Erst stillhalten. Dann bewegen, dort stillhalten und die Eingabetaste drücken. Den Weg mit einem Lineal messen: Zahlen und Punkt hier kommen vom Gerät, das geprüft wird.
feel-port-move = Instrument in einem Trokar: halb herausgezogen beginnen. Es schwenkt um den Trokar, während sich der Griff bewegt; nur der Weg des Griffs zählt.
feel-port-draw = Instrument in einem Trokar: das Instrument am Schaft herausziehen, soweit das { $way } führt, und für den Rest kippen. Nur der Weg des Griffs zählt.
feel-port-hold = Instrument in einem Trokar: halb herausgezogen halten, damit es in beide Richtungen gleiten kann.
feel-port-pushed = Instrument in einem Trokar: nach dem Weg des Griffs antworten. Ein Druck, der es herauszieht, geht nach oben oder zu sich her; einer, der es hineinschiebt, nach unten oder von sich weg.
feel-port-scale = Instrument in einem Trokar: so weit herausziehen, dass die Waage unter den Griff passt, und den Griff darauf absetzen.
feel-hold = Den Griff locker in der Mitte seines Arbeitsraums halten
feel-hold-note-push = Dann die Eingabetaste drücken. Er drückt eine Sekunde lang sanft. Bitte spüren, wohin.
feel-hold-note-response = Dann die Eingabetaste drücken. Er drückt 9 s lang sanft hin und her.
feel-push = Er drückt mit { $newton } N …
feel-push-note = Kraft und Griff sind hier verborgen, denn nur die Hand soll urteilen.
feel-ask-pushed = Wohin hat er gedrückt?
feel-answer-right = Rechts (R)
feel-answer-left = Links (L)
feel-answer-up = Oben (U)
feel-answer-down = Unten (D)
feel-answer-towards = Zu mir her (T)
feel-answer-away = Von mir weg (A)
feel-answer-nothing = Nichts gespürt (N)
feel-shut = Den Griff ganz schließen
feel-open = Den Griff ganz öffnen
feel-ends-note = Dort halten und die Eingabetaste drücken.
feel-hold-fingers = Den Griff mit lockeren Fingern halb offen halten
feel-push-fingers = Er drückt mit { $newton } N gegen die Finger …
feel-ask-fingers = Wohin hat er die Finger gedrückt?
feel-answer-open = Auf (O)
feel-answer-shut = Zu (S)
feel-ask-scale = Ist eine Küchenwaage zur Hand?
feel-ask-scale-note = Der Griff würde mit einem halben Newton darauf drücken: so schwer wie 51 g.
feel-yes = Ja (J)
feel-no = Nein (N)
feel-scale = Die Spitze des Griffs auf die Waage stellen
feel-scale-note = Die Waage auf null stellen. Dann die Eingabetaste drücken.
feel-press = Er drückt mit { $newton } N nach unten. Bitte die Waage ablesen
feel-press-note = Nach dem Ablesen die Eingabetaste drücken. Dann endet die Kraft.
feel-ask-pressed = Was hat die Waage gezeigt?
feel-ask-pressed-note = Gramm eintippen und die Eingabetaste drücken. Das Feld leer lassen, wenn nichts abzulesen war.
feel-grams-wrong = Das ist kein Gewicht in Gramm, wie etwa 51,5.
feel-take = Übernehmen (Eingabe)
feel-response = Er drückt 9 s lang hin und her …
feel-response-note = Locker halten.
feel-done = Fertig (Eingabe)
feel-stop = Abbrechen: keine Kraft (Esc)
feel-close = Schließen (Eingabe)
feel-passed = Das Gerät hat bestanden
feel-failed = Das Gerät hat nicht bestanden
feel-check-ok = gut
feel-check-fail = nicht bestanden
feel-check-open = nicht beurteilt
feel-check-skipped = ausgelassen
feel-terminal = Diese Liste steht auch im Terminal.
feel-position = Ort, mm
feel-velocity = Geschwindigkeit, mm/s
feel-force = Kraft, N
feel-opening = Öffnung, %
feel-opening-force = Öffnende Kraft, N
feel-x = rechts
feel-y = oben
feel-z = zu Ihnen
feel-axis-x = rechts (x)
feel-axis-y = oben (y)
feel-axis-z = zu Ihnen (z)
feel-hidden = verborgen
feel-none = noch keine
feel-outside = Laut Gerät ist der Griff weiter weg, als dieses Bild zeigt.
