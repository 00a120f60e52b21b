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
scope = Endoskop: { $angle }°, Kabel um { $turned }° gedreht
scope-next = Nächstes Endoskop (S)
scope-left = Nach links drehen ([)
scope-right = Nach rechts drehen (])
scope-wipe = Linse wischen (W)
scope-dirty = Linse: beschlagen oder verrußt, bitte wischen
scope-held = Kamera: vom Fußschalter gehalten
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
