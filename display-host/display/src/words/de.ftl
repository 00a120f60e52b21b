# Was die Oberfläche auf Deutsch sagt. Zahlen kommen als Text, vom Programm gerundet.

## Aufgaben
task-identify = Darstellen: Ductus cysticus und Arteria cystica zeigen
task-clamp = Clippen: Ductus cysticus und Arteria cystica verschließen
task-cut = Durchtrennen: beide zwischen den Clips schneiden
task-disconnect = Ablösen: die Gallenblase von der Leber trennen
task-full = Die ganze Operation
task-free = Freies Üben
task-none = Drücken, greifen und ziehen: die Organe fühlen
task-scope = Endoskop: die Organe der Reihe nach zeigen

## Instrumente
instrument-0 = Fasszange
instrument-1 = Häkchen
instrument-2 = Schere
instrument-3 = Clipzange
instrument-unknown = Unbekanntes Instrument

device-haptic = Haptisches Gerät
device-tracker = Sensor des Endoskops
device-pedal = Fußschalter

## Während der Aufgabe
hud-clips = noch { $count } Clips
hud-pedal-none = Fußschalter: nichts
hud-pedal-cut = Fußschalter: Schneiden
hud-pedal-coagulate = Fußschalter: Koagulieren
hud-pedal-both = Fußschalter: beide gedrückt, keiner wirkt
hud-camera-held = Kamera steht
hud-alarm = Alarm: { $text }
hud-hint = Als Nächstes: { $text }

## Pause
pause-title = Angehalten
pause-go-on = Weiter (P)
pause-again = Von vorn (R)
pause-end = Beenden (Esc)
pause-note = Solange die Simulation steht, ist die Kraft aus.

## Einstellungen
settings = Einstellungen (O)
settings-title = Einstellungen
settings-language = Sprache
settings-text = Schriftgröße
settings-sound = Ton
settings-sound-on = an
settings-sound-off = aus
settings-screen = Ganzer Bildschirm (F11)
settings-close = Zurück (Esc)

## Eine Sitzung, noch einmal gezeigt
replay-at = { $at } von { $length }
replay-slider = Zeitpunkt der Sitzung
replay-step = { $step } s
replay-speed = { $speed }×
replay-seeks = von { $at } nach { $to } …
replay-free = Freie Kamera (C)
replay-free-help = Bild ziehen: umsehen, Rad: näher. Pfeile: 1 s, Bild auf und ab: 10 s, Pos1: der Anfang.

## Die Aufzeichnung
recording-on = Aufzeichnung läuft, { $megabytes } MB
recording-waits = Aufzeichnung: Platte voll oder weg, { $megabytes } MB warten; Platz schaffen
recording-hangs = Aufzeichnung: die Platte antwortet seit Sekunden nicht; bitte prüfen
recording-gap = Aufzeichnung läuft, aber { $missing } Takte fehlen
recording-events = Aufzeichnung läuft, aber { $missing } Ereignisse fehlen
recording-ended = Keine Aufzeichnung mehr: die Platte war zu lange voll

## Alarme
alarm-touched = berührt: { $organ }
alarm-burnt = verbrannt: { $organ }
alarm-cut = geschnitten: { $organ }
alarm-torn = gerissen: { $organ }
alarm-perforated = eröffnet: { $organ }
alarm-crushed = gequetscht: { $organ }; weniger fest greifen
alarm-clip-lost = ein Clip schloss ins Leere
alarm-clip-misplaced = ein Clip sitzt auf: { $organ }
alarm-too-early = geclippt, ehe die kritische Sicht da war: { $organ }
alarm-unclamped = ohne Clips durchtrennt: { $organ }

## Wie es um eine Aufgabe steht
task-time = Zeit: { $time }
task-score = { $score } von 100 Punkten
task-done = { $step } (getan)
task-to-do = { $step } (zu tun)
task-hint = Tipp: { $text }
task-alarm = Alarm { $number }: { $text }
task-end = { $outcome }: { $reasons }
outcome-running = Läuft
outcome-passed = Bestanden
outcome-failed = Nicht bestanden
outcome-aborted = Vor dem Ziel beendet
outcome-practised = Geübt
hud-end = Ende: zum Bericht (Esc)

## Die Leiste
quit = Beenden (Esc)
alarm = Alarm: { $text }
alarm-acknowledge = Gesehen (A)
waiting-other-scene = Die Steuerung hat eine andere Szene.
    Diese Anzeige hat „{ $scene }“: beide mit derselben starten.
waiting-picture = Das Bild wird vorbereitet
waiting-controller = Warten auf die Steuerung der Station „{ $station }“.
    Eine starten mit: calot rt
controller-paused = Steuerung: angehalten
controller-live = Steuerung: läuft
controller-waiting = Steuerung: wird erwartet
controller-silent = Steuerung: schweigt seit { $seconds } s
controller-other-scene = Steuerung: hat eine andere Szene
device-unknown = { $device }: unbekannt
device-absent = { $device }: nicht angeschlossen
device-live = { $device }: bereit, { $age } ms alt
device-stale = { $device }: verspätet, { $age } ms alt
device-lost = { $device }: Leitung verloren: bitte neu einstecken
device-odd = { $device }: unbekannter Zustand { $status }
device-bad = { $state }, { $count } Meldungen fehlerhaft oder verloren
instrument = Instrument
scope = Endoskop: { $angle }°, Kabel um { $turned }° gedreht, Schärfe { $focus } mm
scope-next = Nächstes Endoskop (S)
scope-left = Nach links drehen ([)
scope-right = Nach rechts drehen (])
scope-nearer = Schärfe näher (-)
scope-farther = Schärfe ferner (+)
scope-wipe = Linse wischen (W)
scope-dirty = Linse: beschlagen oder verrußt, bitte wischen
scope-held = Kamera: vom Fußschalter gehalten
smoke-draw-off = Rauch absaugen (D)
smoke-close = Ventil schließen (D)
smoke-drawn-off = Rauch: wird durch den Trokar abgesaugt
smoke-gathers = Rauch: verdeckt die Sicht, bitte absaugen
switch-pause = Anhalten (P)
switch-go-on = Weiter (P)
switch-reset = Organe zurücksetzen (R)
switch-engineering = Technische Ansicht (E)
switch-hand = Instrument nehmen: Maus und Tastatur (M)
switch-hand-off = Instrument loslassen (M)
switch-force = Kraft einschalten (F)
switch-force-off = Kraft ausschalten (F)
help = Maus oder Pfeile: bewegen   Rad oder Bild-Tasten: tiefer, heraus   Links oder Leertaste: Maul   Rechts oder V: koagulieren   C: schneiden   , und .: rollen
    Mittlere Taste oder Strg: Endoskop   L: Kamera halten   Umschalt: langsam   M oder Esc: loslassen
force = Kraft auf die Hand: { $force } N
force-cut = Kraft auf die Hand: { $force } N, ausgeschaltet
picture = Bild: { $rate } in der Sekunde, { $age } ms nach der Hand
picture-alt = Bild des Endoskops
quality = Qualität: { $tier } von { $tiers }, 1 ist die beste
graphics = Grafik: { $ms } ms je Bild
pass-skinning = Haut
pass-shadow = Schatten
pass-scene = Organe und Instrumente
pass-exposure = Belichtung
pass-glare = Überstrahlung
pass-lens = Linse
pass-time = { $name }: { $ms } ms

## Takte und Sicherheitskette
ticks-none = Takte: noch nichts bekannt
ticks-realtime = Echtzeit: ja
ticks-lacks = Keine Echtzeit: es fehlt { $what }
ticks-rate = Takte: { $rate } in der Sekunde
ticks-counts = Versäumt { $missed }, verspätet { $late }, Speicheranforderungen { $allocations }, Seitenfehler { $faults }
ticks-wake = Aufwachen: 99 % binnen { $most } µs, längstens { $worst } µs
ticks-tick = Takt: 99 % binnen { $most } µs, längstens { $worst } µs
ticks-wake-name = Verzug beim Aufwachen
ticks-tick-name = Dauer eines Takts
ticks-bars = { $name }, 1 µs bis 33 ms, jeder Balken das Doppelte des vorigen
lacks-fifo = SCHED_FIFO
lacks-locked = gesperrter Speicher
lacks-core = ein eigener Kern
gates = Sicherheitskette: griff { $count } Mal ein
gate = { $count } × { $what }
gate-bad-sample = Lagen übergangen: keine Zahl oder außerhalb des Raums
gate-speed-trip = ausgeschaltet: der Griff war zu schnell
gate-bad-force = keine gegeben: die Kraft war keine Zahl
gate-not-enabled = keine gegeben: niemand hat sie eingeschaltet
gate-lost-device = ausgeschaltet: die Leitung des Geräts war fort
gate-stale-device = abgesenkt: das Gerät war verspätet
gate-ramped = angehoben: nach dem Einschalten oder in einer Pause
gate-stiffness-capped = weicher, wie das Gerät es stabil darstellt
gate-damped = gedämpft: der Kontakt gab der Hand Energie
gate-clamped = gekürzt auf das Höchste des Geräts
gate-thermal-limited = gesenkt: die Motoren sind warm
gate-slewed = verlangsamt: die Kraft änderte sich zu schnell

## Was Kraft oder Strom nimmt
fault-no-number = die Kraft war keine Zahl: sie ist aus
fault-late = das haptische Gerät ist verspätet: die Kraft fällt auf null
fault-gone = das haptische Gerät ist fort: die Kraft ist aus
fault-fast = der Griff war zu schnell: die Kraft ist aus, bis sie eingeschaltet wird (F)
fault-both = beide Elektroden zugleich verlangt: keine wirkt

## Was verlangt und nicht getan wurde
command-not-done = Nicht getan: { $what }. { $why }
command-pause = anhalten oder weiter
command-start = die Aufgabe von vorn beginnen
command-reset = die Organe zurücksetzen
command-force = die Kraft schalten
command-instrument = ein anderes Instrument nehmen
command-seek = zu einem anderen Zeitpunkt gehen
command-speed = andere Geschwindigkeit
command-other = ein Befehl
refused-unknown = Die Steuerung kennt das nicht: vielleicht ist sie eine andere Version.
refused-range = Das hat die Steuerung nicht.
refused-busy = Bei der Steuerung wartet zu viel: bitte noch einmal.
refused-otherwise = Die Steuerung lehnte es ab (Antwort { $answer }).
service-no-answer = Keine Steuerung antwortet: läuft die Station?
service-other-version = Auf dieser Station läuft ein Prozess einer anderen Version: bitte beenden.
hand-elsewhere = Eine andere Anzeige hat das Instrument in der Hand: dort loslassen (M).
hand-nobody = Keine nachgebildete Hand ist zu übernehmen: das Instrument gehört einem echten Gerät, oder die Station läuft nicht.

## Der Starter
launcher-start = Beginn
launcher-running = Operation läuft
launcher-debrief = Nachbesprechung
launcher-questions = Fragebogen
launcher-sheet = Bogen der Ausbilder
launcher-failed = Keine Operation

## Beginn
start-title = Was soll getan werden?
start-begin = Beginnen (Eingabe)
start-trainee = Wer übt
start-nobody = Niemand
start-new-name = Neuer Name (N)
start-not-kept = Ohne Namen wird die Sitzung nicht aufgehoben.
start-kept = Aufgehoben in { $store }
start-task = Aufgabe
start-asks-identify = Calots Dreieck und das untere Drittel der Gallenblase mit dem Häkchen frei legen, bis nur Gang und Arterie in die Gallenblase führen.
start-asks-clamp = Ductus cysticus und Arteria cystica mit Clips verschließen: genug, mit Abstand, und sonst nichts.
start-asks-cut = Gang und Arterie mit der Schere durchtrennen, jeden zwischen seinen Clips.
start-asks-disconnect = Die Gallenblase mit dem Häkchen aus ihrem Bett lösen, ohne sie oder die Leber zu eröffnen.
start-asks-full = Alle vier der Reihe nach, von der ersten Berührung bis zur gelösten Gallenblase.
start-asks-free = Nichts wird verlangt, alles gemessen.
start-asks-scope = Mit dem Endoskop ein Organ nach dem anderen zeigen, waagrecht und ruhig.
start-own-sutures = Die Fäden, an denen die Gallenblase hängt, selbst setzen
start-difficulty = Hilfe
start-scope = Endoskop
start-scene = Szene
scene-triangle = Calots Dreieck
scene-triangle-variant = Calots Dreieck, ungewöhnlicher Verlauf
scene-built-in = Vier Organe
start-devices = Geräte
start-emulated = Nachgebildet
start-by-file = Nach Stationsdatei
start-station-file = Stationsdatei
start-device-emulated = { $device }: nachgebildet
start-device-there = { $device }: { $path } ist da
start-device-missing = { $device }: { $path } ist nicht da. Einstecken, oder die nachgebildeten wählen
start-device-named = { $device }: { $path }, wird zu Beginn gesucht
start-hand = M nimmt das Instrument mit Maus und Tastatur; sonst arbeitet eine vorgegebene Hand.
start-nothing-plugged-in = Keine serielle Leitung und kein Fußschalter eingesteckt.
start-plugged-in = Eingesteckt: { $list }
start-no-file = Eine Stationsdatei nennen, oder die nachgebildeten Geräte wählen.

difficulty-beginner = Anfänger
difficulty-beginner-gives = Der nächste Schritt wird gesagt; Alarme und Fortschritt sind zu sehen.
difficulty-trainee = Übende
difficulty-trainee-gives = Alarme und Fortschritt sind zu sehen.
difficulty-exam = Prüfung
difficulty-exam-gives = Nur Zeit und Aufgabe sind zu sehen; was falsch war, wird am Ende gesagt.
start-no-folder = { $path }: { $problem }. Einen anderen Ort mit --sessions nennen.
start-no-process = Die Operation ließ sich nicht starten: { $problem }

## Der Speicher der Übenden, und Stationsdateien
store-no-home = Es gibt keinen eigenen Ordner: die Datei des Speichers mit --store nennen.
store-io = { $path }: { $problem }. Eine andere Datei mit --store nennen.
store-foreign = { $path } ist kein Speicher von Calot und bleibt, wie es ist. Eine andere Datei mit --store nennen.
store-version = { $path } ist ein Speicher der Version { $problem }, von einem anderen Calot, und bleibt, wie er ist. Jenes nehmen, oder eine andere Datei mit --store nennen.
store-damaged = { $path } ist beschädigt ({ $problem }) und bleibt, wie es ist. Eine Kopie zurücklegen, oder es wegräumen und neu beginnen.
store-busy = { $path } ist in Gebrauch: ein anderes Programm schreibt hinein. Danach noch einmal versuchen.
store-log = { $path } hat ein Protokoll daneben ({ $problem }), und ein anderes Programm hält es offen. Niemand wurde vergessen: die Programme beenden, die es offen haben, und noch einmal versuchen.
store-sqlite = { $path }, Datenbank: { $problem }
store-no-trainee = Niemand heißt „{ $name }“ im Speicher.
store-no-session = Die Sitzung ist nicht im Speicher.
store-taken = Die Sitzung steht unter einem anderen Namen im Speicher.
store-value = { $value } liegt außerhalb des Erlaubten.
store-questions = Fragebogen: { $problem }
store-name = { $name } ist kein Name, der aufgehoben werden kann: 1 bis 64 Zeichen, keines davon unsichtbar.
station-file-none = { $path } ist keine Stationsdatei, sondern ein Ordner, eine Pipe oder ein Gerät. Eine Textdatei (TOML) nennen, die die Geräte nennt.
station-file-unread = { $path } ist nicht zu lesen: { $problem }
station-file-wrong = { $path }, Zeile { $line }: { $problem }

## Während operiert wird
running-title = Die Operation läuft
running-ending = Die Operation endet
running-note = Sie hat ihr eigenes Fenster: Esc beendet sie dort. Dann erscheint hier die Nachbesprechung.
running-stop = Beenden (S)
running-stop-at-once = Sofort beenden: ohne Bericht (S)

## Nichts zu besprechen
failed-title = Die Operation fand nicht statt
failed-status = Die Station endete: { $status }
failed-note = Dies hat sie zuletzt gesagt. Beheben, was sie nennt, oder anders wählen.
failed-again = Noch einmal versuchen (Eingabe)
failed-emulated = Mit nachgebildeten Geräten versuchen
failed-quit = Beenden
failed-code = mit Code { $number }
failed-signal = durch Signal { $number }
failed-recorded = Die Aufnahme ist da: calot store add NAME '{ $path }'

## Nachbesprechung
debrief-again = Noch einmal (Eingabe)
debrief-another = Andere Aufgabe (Esc)
debrief-report = Ganzen Bericht öffnen (R)
debrief-questions = Fragebogen (Q)
debrief-sheet = Bogen der Ausbilder (I)
debrief-answered = Fragebogen: beantwortet
debrief-sheet-points = Bogen der Ausbilder: { $points } von 25
debrief-errors = Was falsch war
debrief-no-errors = Nichts.
debrief-past = Zuvor
debrief-no-past = Noch keine Sitzung zum Vergleich.
debrief-metrics = Was zählt
debrief-report-opened = Der Bericht ist geöffnet: { $path }
debrief-report-lies = Der Bericht liegt in { $path }; kein Programm hat ihn geöffnet ({ $problem }).
metric = Maß
metric-now = Jetzt
metric-rule = Zum Bestehen
metric-best = Bestes
sheet-not-whole = Fünf Punkte werden gebraucht.

## Punkte von 1 bis 5
points-about = Über { $name }
points-number = { $number } von { $of }
points-scale = 1: gar nicht. 5: sehr. Die Tasten 1 bis 5 antworten.
points-all = Alle sind beantwortet:
points-keep = Aufheben (Eingabe)
points-previous = Die vorige (Rücktaste)
points-back = Zurück, ohne aufzuheben (Esc)

question-anatomy = Wie echt ist die Anatomie?
question-triangle = Wie echt ist es, Calots Dreieck zu finden und zu zeigen?
question-interface = Wie echt sieht das Bild aus?
question-instruments = Wie echt ist der Umgang mit den Instrumenten?
question-electric-dissection = Wie echt ist das Präparieren mit Strom?
question-removal = Wie echt ist das Ablösen der Gallenblase?
question-laparoscopy = Wie echt ist es neben derselben Arbeit in der üblichen Laparoskopie?
question-force-quality = Wie gut ist die Kraft, die Sie fühlen?
question-force-use = Wie nützlich ist die Kraft, die Sie fühlen?
question-hand-eye = Wie nützlich ist es für das Zusammenspiel von Hand und Auge?
question-both-hands = Wie nützlich ist es für die Arbeit mit beiden Händen?
question-notes-skills = Wie nützlich ist es für die Grundlagen der Chirurgie durch natürliche Öffnungen?
question-measures = Wie sehr trauen Sie seinen Maßen der Leistung?
question-other-coordination = Wie sicher sind Sie, dass Hand und Auge anders zusammenarbeiten als mit zwei Zugängen?

goals-depth = Tiefenwahrnehmung: 1 verfehlt und berichtigt langsam, 5 geht geradewegs zum Ziel
goals-hands = Beidhändigkeit: 1 nur eine Hand, 5 beide Hände für die beste Sicht
goals-efficiency = Wirksamkeit: 1 unsicher, viele Versuche, 5 sicher und stetig
goals-tissue = Umgang mit Gewebe: 1 grob, reißt und verletzt, 5 schonend, ohne Verletzung
goals-autonomy = Selbständigkeit: 1 auch unter Anleitung nicht, 5 allein

## Maße
metric-score = Punkte
metric-time-s = Zeit
metric-gaps-s = Lücken der Aufnahme
metric-restarts = Neu begonnen
metric-lost-events = Verlorene Ereignisse
metric-path-m = Weg des Instruments
metric-scope-path-m = Weg des Endoskops
metric-movements = Bewegungen des Instruments
metric-scope-movements = Bewegungen des Endoskops
metric-economy = Sparsamkeit der Bewegung
metric-idle-s = Ruhezeit
metric-force-max-n = Größte Kraft
metric-force-mean-n = Mittlere Kraft
metric-force-p95-n = Kraft, 95 % der Zeit
metric-force-saturated-s = Zeit an der Grenze des Geräts
metric-cautery-on-s = Strom an
metric-cautery-air-s = Strom ins Leere
metric-burn-wrong-j = Energie ins Falsche
metric-burn-liver-j = Energie in die Leber
metric-burn-gallbladder-j = Energie in die Gallenblase
metric-burn-duct-j = Energie in Gänge
metric-burn-vessel-j = Energie in Arterien
metric-burn-target-j = Energie in Fett und Bindegewebe
metric-touches-wrong = Falsches berührt
metric-burns-wrong = Falsches verbrannt
metric-cuts-wrong = Falsches geschnitten
metric-clips-used = Clips gesetzt
metric-clips-lost = Clips verloren
metric-clips-misplaced = Clips falsch gesetzt
metric-clips-duct = Clips auf dem Ductus cysticus
metric-clips-artery = Clips auf der Arteria cystica
metric-clip-spacing-mm = Kleinster Abstand der Clips
metric-cuts-one-sided = Neben den Clips durchtrennt
metric-unclamped = Ohne Clips durchtrennt
metric-blood-ml = Blutverlust
metric-bile-ml = Galleverlust
metric-perforations = Perforationen
metric-crushes = Gequetscht
metric-tears = Gerissen
metric-slips = Abgerutscht
metric-out-of-view-s = Instrument außer Sicht
metric-scope-turn-deg = Endoskop gedreht
metric-scope-tilt-deg = Horizont aus der Waage
metric-exchanges = Instrumente gewechselt
metric-cvs-triangle = Dreieck frei gelegt
metric-cvs-bed = Unteres Drittel vom Bett gelöst
metric-cvs-two = Nur zwei Strukturen
metric-bed = Bett frei gelegt
metric-alarms = Alarme insgesamt

## Ausbilder
observe-title = Ausbilder: Station „{ $station }“
observe-no-task = Keine Aufgabe: freies Arbeiten, ohne Bewertung
observe-difficulty = Hilfe: { $difficulty }
observe-metrics = Maße bisher
observe-alarms = Alarme
observe-no-alarms = Noch keine

## Die technische Ansicht
inside-counts = { $spheres } Kugeln, { $links } Federn, { $tetrahedra } Tetraeder; { $touched } Kugeln berührt
inside-asleep = Alle { $organs } Organe schlafen
inside-awake = Wach { $awake } von { $organs }: { $names }
inside-legend = Kugeln: grau schläft, blau wach, weiß befestigt, orange berührt, rosa gegriffen.
    Türkis: das Instrument; magenta: wo die Hand es hält; gelb: die Kraft, 2 cm je Newton.

## Organe, wie Szenen sie nennen
organ-liver = Leber
organ-gallbladder = Gallenblase
organ-connective-tissue = Bindegewebe
organ-cystic-duct = Ductus cysticus
organ-bile-duct = Gallengang
organ-hepatic-artery = Leberarterie
organ-cystic-artery = Arteria cystica
organ-fat = Fett
organ-stomach = Magen
organ-duodenum = Zwölffingerdarm
organ-intestine = Darm

## Was die Bewertung sagt: was zu tun ist, was hilft, warum es vorbei ist
reason-not-done = nicht getan: { $step }
hint-hold = { $step }. In der Mitte des Bildes halten.
hint-take = { $step }. Dazu: { $instrument } ({ $key }).
hint-grasper = { $step }. Berühren, Pedal treten, den Faden zur Bauchwand führen, wieder treten.
hint-hook = { $step }. Einen Strang aufladen, frei heben, dann ein kurzer Strom.
hint-clip-applier = { $step }. Beide Backen darum, die Spitzen im Bild, dann schließen.
hint-scissors = { $step }. Beide Clips sehen, ehe die Klingen schließen.
step-hang = Die Gallenblase an { $count } Fäden aufhängen
step-triangle = Calots Dreieck frei legen
step-lower-bed = Das untere Drittel aus dem Bett der Gallenblase lösen
step-leave-whole = Ductus cysticus und Arteria cystica ganz lassen
step-clip = { $count } Clips setzen: { $organ }
step-divide = Zwischen Clips durchtrennen: { $organ }
step-free = Die Gallenblase von der Leber lösen
step-show = Zeigen: { $organ }
reason-unclamped = ohne Clips durchtrennt: { $organ }
reason-not-whole = Ductus cysticus oder Arteria cystica ist nicht mehr ganz
reason-too-long = es dauerte länger als { $limit }
reason-too-little = { $metric }: { $value }, verlangt mindestens { $limit }
reason-too-much = { $metric }: { $value }, erlaubt höchstens { $limit }
hint-instrument-grasper = Fasszange
hint-instrument-hook = Häkchen
hint-instrument-clip-applier = Clipzange
hint-instrument-scissors = Schere
