# What the interface says, in English. Numbers come as text, rounded by the program.

## Tasks
task-identify = Identify: show cystic duct and artery
task-clamp = Clamp: clip cystic duct and artery
task-cut = Cut: divide both between the clips
task-disconnect = Disconnect: free the gallbladder from the liver
task-full = The whole operation
task-free = Free practice
task-none = Press, grasp and pull: feel the organs
task-scope = Endoscope: show the organs in turn

## Instruments
instrument-0 = Grasper
instrument-1 = Cautery hook
instrument-2 = Scissors
instrument-3 = Clip applier
instrument-unknown = Unknown instrument

device-haptic = Haptic device
device-tracker = Endoscope tracker
device-pedal = Foot pedal

## During a task
hud-clips = { $count } clips left
hud-pedal-none = Pedal: nothing
hud-pedal-cut = Pedal: cut
hud-pedal-coagulate = Pedal: coagulate
hud-pedal-both = Pedal: both pressed, neither works
hud-camera-held = Camera held
hud-alarm = Alarm: { $text }
hud-hint = Next: { $text }

## Pause
pause-title = Paused
pause-go-on = Go on (P)
pause-again = Start again (R)
pause-end = End (Esc)
pause-note = The force is off while the simulation stands still.

## Settings
settings = Settings (O)
settings-title = Settings
settings-language = Language
settings-text = Size of the text
settings-sound = Sound
settings-sound-on = on
settings-sound-off = off
settings-screen = Fill the screen (F11)
settings-close = Back (Esc)

## A session shown again
replay-at = { $at } of { $length }
replay-slider = Moment of the session
replay-step = { $step } s
replay-speed = { $speed }×
replay-seeks = going from { $at } to { $to } …
replay-free = Free camera (C)
replay-free-help = Drag the picture to look around, the wheel goes nearer. Arrows: 1 s, page up and down: 10 s, Home: the start.

## The recording
recording-on = Recording, { $megabytes } MB
recording-waits = Recording: the disk is full or gone, { $megabytes } MB wait; make room
recording-hangs = Recording: the disk has not answered for seconds; check it
recording-gap = Recording, but { $missing } ticks are missing
recording-events = Recording, but { $missing } events are missing
recording-ended = No longer recording: the disk was full for too long

## Alarms
alarm-touched = touched: { $organ }
alarm-burnt = burnt: { $organ }
alarm-cut = cut: { $organ }
alarm-torn = torn: { $organ }
alarm-perforated = opened: { $organ }
alarm-crushed = crushed: { $organ }; grip less
alarm-clip-lost = a clip closed on nothing
alarm-clip-misplaced = a clip on: { $organ }
alarm-too-early = clipped before the critical view was there: { $organ }
alarm-unclamped = divided unclamped: { $organ }

## How a task stands
task-time = Time: { $time }
task-score = Score: { $score } of 100
task-done = { $step } (done)
task-to-do = { $step } (to do)
task-hint = Hint: { $text }
task-alarm = Alarm { $number }: { $text }
task-end = { $outcome }: { $reasons }
outcome-running = Running
outcome-passed = Passed
outcome-failed = Failed
outcome-aborted = Ended before it was done
outcome-practised = Practised
hud-end = End: to the report (Esc)

## The panel
quit = Quit (Esc)
alarm = Alarm: { $text }
alarm-acknowledge = Acknowledge (A)
waiting-other-scene = The controller runs another scene.
    This display has '{ $scene }': start both with the same one.
waiting-picture = Preparing the picture
waiting-controller = Waiting for the controller on station '{ $station }'.
    Start one with: calot rt
controller-paused = Controller: paused
controller-live = Controller: live
controller-waiting = Controller: waiting for it
controller-silent = Controller: silent for { $seconds } s
controller-other-scene = Controller: runs another scene
device-unknown = { $device }: unknown
device-absent = { $device }: not connected
device-live = { $device }: live, { $age } ms old
device-stale = { $device }: stale, { $age } ms old
device-lost = { $device }: line lost: plug it in again
device-odd = { $device }: unknown status { $status }
device-bad = { $state }, { $count } frames bad or lost
instrument = Instrument
scope = Endoscope: { $angle }°, cable turned { $turned }°, focus { $focus } mm
scope-next = Next endoscope (S)
scope-left = Turn left ([)
scope-right = Turn right (])
scope-nearer = Focus nearer (-)
scope-farther = Focus farther (+)
scope-wipe = Wipe lens (W)
scope-dirty = Lens: fogged or sooty, wipe it
scope-held = Camera: held still by the pedal
smoke-draw-off = Draw off smoke (D)
smoke-close = Close the valve (D)
smoke-drawn-off = Smoke: being drawn off through the trocar
smoke-gathers = Smoke: hides what lies behind it, draw it off
switch-pause = Pause (P)
switch-go-on = Go on (P)
switch-reset = Reset organs (R)
switch-engineering = Engineering view (E)
switch-hand = Take the instrument: mouse and keyboard (M)
switch-hand-off = Let go of the instrument (M)
switch-force = Enable force (F)
switch-force-off = Cut force (F)
help = Mouse or arrows: move   Wheel or Page keys: deeper, out   Left or Space: jaws   Right or V: coagulate   C: cut   , and .: roll
    Middle button or Ctrl: endoscope   L: hold the camera   Shift: slow   M or Esc: let go
force = Force on the hand: { $force } N
force-cut = Force on the hand: { $force } N, cut
picture = Picture: { $rate } a second, { $age } ms after the hand
picture-alt = Endoscope picture
quality = Quality: { $tier } of { $tiers }, 1 the best
graphics = Graphics: { $ms } ms a picture
pass-skinning = Skin
pass-shadow = Shadow
pass-scene = Organs and instruments
pass-exposure = Exposure
pass-glare = Glare
pass-lens = Lens
pass-time = { $name }: { $ms } ms

## Ticks and safety chain
ticks-none = Ticks: no record yet
ticks-realtime = Realtime: yes
ticks-lacks = Not realtime: lacks { $what }
ticks-rate = Ticks: { $rate } a second
ticks-counts = Missed { $missed }, late { $late }, allocations { $allocations }, page faults { $faults }
ticks-wake = Wake-up: 99 % within { $most } µs, worst { $worst } µs
ticks-tick = Tick: 99 % within { $most } µs, worst { $worst } µs
ticks-wake-name = Wake-up latency
ticks-tick-name = Time of a tick
ticks-bars = { $name }, 1 µs to 33 ms, each bar twice the last
lacks-fifo = SCHED_FIFO
lacks-locked = locked memory
lacks-core = its own core
gates = Safety chain: acted { $count } times
gate = { $count } × { $what }
gate-bad-sample = poses ignored: not a number, or outside the room
gate-speed-trip = cut: the handle was too fast
gate-bad-force = none given: the force was no number
gate-not-enabled = none given: a person has not enabled it
gate-lost-device = cut: the device's line was gone
gate-stale-device = faded: the device was late
gate-ramped = ramped: after it was enabled, or in a pause
gate-stiffness-capped = softened to what the device renders stably
gate-damped = damped: contact gave the hand energy
gate-clamped = shortened to the device's peak
gate-thermal-limited = lowered: the motors are warm
gate-slewed = slowed: the force changed too fast

## What takes the force or the current away
fault-no-number = the force was not a number: it is off
fault-late = the haptic device is late: force falls to zero
fault-gone = the haptic device is gone: force is off
fault-fast = the handle was too fast: force is off until enabled (F)
fault-both = both electrodes are asked at once: neither works

## What was asked for and not done
command-not-done = Not done: { $what }. { $why }
command-pause = pause or go on
command-start = begin the task again
command-reset = reset the organs
command-force = switch the force
command-instrument = take another instrument
command-seek = go to another moment
command-speed = another speed
command-other = a command
refused-unknown = The controller does not know how: it may be of another version.
refused-range = The controller does not have that.
refused-busy = Too much waits at the controller: try again.
refused-otherwise = The controller refused (answer { $answer }).
service-no-answer = No controller answers: is the station running?
service-other-version = A process of another version runs on this station: end it.
hand-elsewhere = Another display has the instrument in hand: let go of it there (M).
hand-nobody = There is no emulated hand to take over: the instrument is a real device's, or the station does not run.

## The launcher
launcher-start = Start
launcher-running = Operation
launcher-debrief = Debrief
launcher-questions = Questionnaire
launcher-sheet = Instructor's sheet
launcher-failed = No operation

## Start
start-title = What is to be done?
start-begin = Begin (Enter)
start-trainee = Trainee
start-nobody = Nobody
start-new-name = New name (N)
start-not-kept = Without a name the session is not kept in the store.
start-kept = Kept in { $store }
start-task = Task
start-asks-identify = Clear Calot's triangle and the gallbladder's lower third with the hook, until only duct and artery enter the gallbladder.
start-asks-clamp = Close cystic duct and cystic artery with clips, enough of them and apart, on nothing else.
start-asks-cut = Divide duct and artery with the scissors, each between its clips.
start-asks-disconnect = Free the gallbladder from its bed on the liver with the hook, and open neither.
start-asks-full = All four in order, from the first touch to the free gallbladder.
start-asks-free = Nothing is asked; everything is measured.
start-asks-scope = Show one organ after the other with the endoscope, level and still.
start-own-sutures = Place the sutures that hang the gallbladder myself
start-difficulty = Help
start-scope = Endoscope
start-scene = Scene
scene-triangle = Calot's triangle
scene-triangle-variant = Calot's triangle, unusual course
scene-built-in = Four organs
start-devices = Devices
start-emulated = Emulated
start-by-file = By a station file
start-station-file = Station file
start-device-emulated = { $device }: emulated
start-device-there = { $device }: { $path } is there
start-device-missing = { $device }: { $path } is not there. Plug it in, or choose the emulated ones
start-device-named = { $device }: { $path }, looked for at the start
start-hand = M takes the instrument with mouse and keyboard; else a scripted hand works.
start-nothing-plugged-in = No serial line or pedal is plugged in.
start-plugged-in = Plugged in: { $list }
start-no-file = Name a station file, or choose the emulated devices.

difficulty-beginner = Beginner
difficulty-beginner-gives = The next step is said; alarms and progress are shown.
difficulty-trainee = Trainee
difficulty-trainee-gives = Alarms and progress are shown.
difficulty-exam = Exam
difficulty-exam-gives = Only time and task are shown; what went wrong is said at the end.
start-no-folder = { $path }: { $problem }. Name another place with --sessions.
start-no-process = The operation could not be started: { $problem }

## The store of trainees, and station files
store-no-home = There is no home folder: name the store's file with --store.
store-io = { $path }: { $problem }. Name another file with --store.
store-foreign = { $path } is no store of Calot; it is left as it is. Name another file with --store.
store-version = { $path } is a store of version { $problem }, made by another Calot; it is left as it is. Use that one, or name another file with --store.
store-damaged = { $path } is damaged ({ $problem }); it is left as it is. Put a copy of it back, or move it away and begin anew.
store-busy = { $path } is in use: another program has it open and writes. Try again when that is done.
store-log = { $path } keeps a log beside it ({ $problem }), and another program holds it open. Nobody was forgotten: end the programs that have it open, and try again.
store-sqlite = { $path }: { $problem }
store-no-trainee = Nobody is called '{ $name }' in the store.
store-no-session = The session is not in the store.
store-taken = The session is in the store under another name.
store-value = { $value } is out of its range.
store-questions = Questionnaire: { $problem }
store-name = { $name } is no name to be kept: 1 to 64 characters, none of them unseen.
station-file-none = { $path } is no station file but a folder, a pipe or a device. Name a text file (TOML) that names the devices.
station-file-unread = { $path } cannot be read: { $problem }
station-file-wrong = { $path }, line { $line }: { $problem }

## While an operation runs
running-title = The operation is running
running-ending = The operation is ending
running-note = It has a window of its own: Esc there ends it. Then its debrief is shown here.
running-stop = Stop (S)
running-stop-at-once = Stop at once: without a report (S)

## Nothing to debrief
failed-title = The operation did not take place
failed-status = The station ended: { $status }
failed-note = This is the last that it said. Mend what it names, or choose otherwise.
failed-again = Try again (Enter)
failed-emulated = Try with emulated devices
failed-quit = End
failed-code = with code { $number }
failed-signal = by signal { $number }
failed-recorded = What was recorded is there: calot store add NAME '{ $path }'

## Debrief
debrief-again = Again (Enter)
debrief-another = Another task (Esc)
debrief-report = Open the full report (R)
debrief-questions = Questionnaire (Q)
debrief-sheet = Instructor's sheet (I)
debrief-answered = Questionnaire: answered
debrief-sheet-points = Instructor's sheet: { $points } of 25
debrief-errors = What was wrong
debrief-no-errors = Nothing.
debrief-past = Before
debrief-no-past = No session to compare with yet.
debrief-metrics = What counts
debrief-report-opened = The report is opened: { $path }
debrief-report-lies = The report is in { $path }; no program here opened it ({ $problem }).
metric = Metric
metric-now = Now
metric-rule = To pass
metric-best = Best before
sheet-not-whole = Five points are needed.

## Points from 1 to 5
points-about = About { $name }
points-number = { $number } of { $of }
points-scale = 1: not at all. 5: very. Keys 1 to 5 answer.
points-all = All are answered:
points-keep = Keep (Enter)
points-previous = The one before (Backspace)
points-back = Back without keeping (Esc)

question-anatomy = How real is the anatomy?
question-triangle = How real is it to find and show Calot's triangle?
question-interface = How real does the picture look?
question-instruments = How real is the handling of the instruments?
question-electric-dissection = How real is dissecting with current?
question-removal = How real is freeing the gallbladder?
question-laparoscopy = How real is it beside the same work in ordinary laparoscopy?
question-force-quality = How good is the force that you feel?
question-force-use = How useful is the force that you feel?
question-hand-eye = How useful is it for the coordination of hand and eye?
question-both-hands = How useful is it for working with both hands?
question-notes-skills = How useful is it for the basic skills of surgery through natural openings?
question-measures = How much do you trust its measures of performance?
question-other-coordination = How sure are you that hand and eye work together differently than with two ports?

goals-depth = Depth perception: 1 overshoots and is slow to correct, 5 goes straight to the target
goals-hands = Bimanual dexterity: 1 one hand alone, 5 both hands to the best exposure
goals-efficiency = Efficiency: 1 uncertain, many attempts, 5 confident and safe, straight on
goals-tissue = Tissue handling: 1 rough, tears and injures, 5 gentle, without injury
goals-autonomy = Autonomy: 1 unable even when guided, 5 alone

## Metrics
metric-score = Score
metric-time-s = Time
metric-gaps-s = Gaps in the recording
metric-restarts = Begun again
metric-lost-events = Events lost
metric-path-m = Path of the instrument
metric-scope-path-m = Path of the endoscope
metric-movements = Movements of the instrument
metric-scope-movements = Movements of the endoscope
metric-economy = Economy of movement
metric-idle-s = Idle time
metric-force-max-n = Greatest force
metric-force-mean-n = Mean force
metric-force-p95-n = Force, 95 % of the time
metric-force-saturated-s = Time at the device's limit
metric-cautery-on-s = Current on
metric-cautery-air-s = Current on nothing
metric-burn-wrong-j = Energy into the wrong
metric-burn-liver-j = Energy into the liver
metric-burn-gallbladder-j = Energy into the gallbladder
metric-burn-duct-j = Energy into ducts
metric-burn-vessel-j = Energy into arteries
metric-burn-target-j = Energy into fat and tissue
metric-touches-wrong = Wrong structures touched
metric-burns-wrong = Wrong structures burnt
metric-cuts-wrong = Wrong structures cut
metric-clips-used = Clips used
metric-clips-lost = Clips lost
metric-clips-misplaced = Clips misplaced
metric-clips-duct = Clips on the cystic duct
metric-clips-artery = Clips on the cystic artery
metric-clip-spacing-mm = Least distance of clips
metric-cuts-one-sided = Divided beside the clips
metric-unclamped = Divided unclamped
metric-blood-ml = Blood lost
metric-bile-ml = Bile lost
metric-perforations = Perforations
metric-crushes = Crushed
metric-tears = Torn
metric-slips = Slipped
metric-out-of-view-s = Instrument out of view
metric-scope-turn-deg = Endoscope turned
metric-scope-tilt-deg = Horizon off the level
metric-exchanges = Instruments exchanged
metric-cvs-triangle = Triangle cleared
metric-cvs-bed = Lower third off the bed
metric-cvs-two = Two structures only
metric-bed = Bed cleared
metric-alarms = Alarms

## Instructor
observe-title = Instructor: station '{ $station }'
observe-no-task = No task: free work, without an assessment
observe-difficulty = Help: { $difficulty }
observe-metrics = Metrics so far
observe-alarms = Alarms
observe-no-alarms = None yet

## The engineering view
inside-counts = { $spheres } spheres, { $links } links, { $tetrahedra } tetrahedra; { $touched } spheres touched
inside-asleep = All { $organs } organs sleep
inside-awake = Awake { $awake } of { $organs }: { $names }
inside-legend = Spheres: grey asleep, blue awake, white held, orange touched, pink grasped.
    Cyan: the tool; magenta: where the hand holds it; yellow: force, 2 cm a newton.

## Organs, as scenes name them
organ-liver = liver
organ-gallbladder = gallbladder
organ-connective-tissue = connective tissue
organ-cystic-duct = cystic duct
organ-bile-duct = bile duct
organ-hepatic-artery = hepatic artery
organ-cystic-artery = cystic artery
organ-fat = fat
organ-stomach = stomach
organ-duodenum = duodenum
organ-intestine = intestine

## What the assessment says: what is to be done, what helps, why it is over
reason-not-done = not done: { $step }
hint-hold = { $step }: hold it in the middle of the picture.
hint-take = { $step }: take the { $instrument } ({ $key }).
hint-grasper = { $step }: touch it, press the pedal, carry the thread towards the wall, press again.
hint-hook = { $step }: hook a strand, lift it clear, then a short current.
hint-clip-applier = { $step }: both jaws around it, tips in sight, then close.
hint-scissors = { $step }: see both clips before the blades close.
step-hang = Hang the gallbladder by { $count } sutures
step-triangle = Clear Calot's triangle
step-lower-bed = Free the lower third of the gallbladder's bed
step-leave-whole = Leave cystic duct and artery whole
step-clip = Put { $count } clips on the { $organ }
step-divide = Divide the { $organ } between clips
step-free = Free the gallbladder from the liver
step-show = Show the { $organ }
reason-unclamped = the { $organ } was divided unclamped
reason-not-whole = cystic duct or artery is no longer whole
reason-too-long = it took longer than { $limit }
reason-too-little = { $metric }: { $value }, at least { $limit } is asked
reason-too-much = { $metric }: { $value }, at most { $limit } is allowed
hint-instrument-grasper = grasper
hint-instrument-hook = cautery hook
hint-instrument-clip-applier = clip applier
hint-instrument-scissors = scissors
