# Texts of the interface in English. The program passes numbers as rounded text.

## Tasks
task-identify = Identify: expose cystic duct and artery
task-clamp = Clamp: clip cystic duct and artery
task-cut = Cut: divide both between the clips
task-disconnect = Disconnect: free the gallbladder from the liver
task-full = The whole operation
task-free = Free practice
task-none = Press, grasp and pull: get to know the organs
task-scope = Endoscope: show each organ in turn

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
hud-pedal-none = Pedal: off
hud-pedal-cut = Pedal: cut
hud-pedal-coagulate = Pedal: coagulate
hud-pedal-both = Both pedals pressed: no current
hud-camera-held = Camera locked
hud-alarm = Alarm: { $text }
hud-hint = Next: { $text }

## Pause
pause-title = Paused
pause-go-on = Resume (P)
pause-again = Restart (R)
pause-end = End (Esc)
pause-note = The force is off while the simulation is paused.

## Settings
settings = Settings (O)
settings-title = Settings
settings-language = Language
settings-text = Text size
settings-sound = Sound
settings-sound-on = on
settings-sound-off = off
settings-screen = Full screen (F11)
settings-close = Back (Esc)

## Replay
replay-at = { $at } of { $length }
replay-slider = Position in the session
replay-step = { $step } s
replay-speed = { $speed }×
replay-seeks = Going from { $at } to { $to } …
replay-free = Free camera (C)
replay-free-help = Drag the picture to look around; turn the wheel to zoom. Arrows: 1 s, Page Up and Page Down: 10 s, Home: start.

## The recording
recording-on = Recording, { $megabytes } MB
recording-waits = Recording: the disk is full or missing, { $megabytes } MB waiting; free some space
recording-hangs = Recording: the disk has not responded for some seconds; check it
recording-gap = Recording, but { $missing } ticks are missing
recording-events = Recording, but { $missing } events are missing
recording-ended = Recording stopped: the disk was full for too long
recording-alarm = the disk does not take the recording; the panel says more

## Alarms
alarm-touched = pressed hard: { $organ }
alarm-burnt = burnt: { $organ }
alarm-cut = cut: { $organ }
alarm-torn = torn: { $organ }
alarm-perforated = perforated: { $organ }
alarm-crushed = crushed: { $organ }; loosen the grip
alarm-clip-lost = closed a clip with no tissue in it
alarm-clip-misplaced = clip misplaced on: { $organ }
alarm-too-early = clipped before the critical view was achieved: { $organ }
alarm-unclamped = open, not closed by clips: { $organ }

## State of a task
task-time = Time: { $time }
task-score = Score: { $score } of 100
task-done = { $step } (done)
task-to-do = { $step } (to do)
task-hint = Hint: { $text }
task-alarm = Alarm { $number }: { $text }
task-end = { $outcome }: { $reasons }
outcome-running = In progress
outcome-passed = Passed
outcome-failed = Failed
outcome-aborted = Not completed
outcome-practised = Practice completed
hud-end = Show the report (Esc)

## The panel
quit = Quit (Esc)
alarm = Alarm: { $text }
alarm-acknowledge = Acknowledge (A)
waiting-other-scene = The controller runs a different scene.
    This display shows '{ $scene }': start both with the same scene.
waiting-picture = Preparing the picture
waiting-controller = Waiting for the controller of station '{ $station }'.
    Start one with: calot rt
controller-paused = Controller: paused
controller-live = Controller: live
controller-waiting = Controller: not started yet
controller-silent = Controller: no response for { $seconds } s
controller-other-scene = Controller: running a different scene
device-unknown = { $device }: unknown
device-absent = { $device }: not connected
device-live = { $device }: ready, last reading { $age } ms ago
device-stale = { $device }: delayed, last reading { $age } ms ago
device-lost = { $device }: connection lost; plug it in again
device-odd = { $device }: unknown status { $status }
device-bad = { $state }, { $count } faulty or lost readings
instrument = Instrument
scope = Endoscope: { $angle }°, light cable turned { $turned }°, focus { $focus } mm
scope-next = Next endoscope (S)
scope-left = Turn left ([)
scope-right = Turn right (])
scope-nearer = Focus nearer (-)
scope-farther = Focus farther (+)
scope-wipe = Clean lens (W)
scope-dirty = Lens: fogged or sooted, clean it
scope-held = Camera: locked by the pedal
smoke-draw-off = Evacuate smoke (D)
smoke-close = Close the valve (D)
smoke-drawn-off = Smoke: being evacuated through the trocar
smoke-gathers = Smoke: obscures the view, evacuate it
switch-pause = Pause (P)
switch-go-on = Resume (P)
switch-reset = Reset organs (R)
switch-engineering = Engineering view (E)
switch-hand = Control with mouse and keyboard (M)
switch-hand-off = Release the instrument (M)
switch-force = Enable force (F)
switch-force-off = Disable force (F)
help = Mouse or arrows: move   Wheel or Page keys: in, out   Left or Space: jaws   Right or V: coagulate   C: cut   , and .: rotate
    Middle button or Ctrl+arrows: endoscope   L: lock the camera   Shift: slow   M or Esc: release
force = Force on the hand: { $force } N
force-cut = Force on the hand: { $force } N, disabled
picture = Picture: { $rate } per second, handed over { $age } ms after the hand moved
picture-alt = Endoscope picture
quality = Quality: level { $tier } of { $tiers } (1 is best)
graphics = Graphics: { $ms } ms per picture
pass-skinning = Surfaces
pass-shadow = Shadows
pass-scene = Organs and instruments
pass-exposure = Exposure
pass-glare = Glare
pass-lens = Lens
pass-time = { $name }: { $ms } ms

## Ticks and safety chain
ticks-none = Ticks: none recorded yet
ticks-realtime = Real time: yes
ticks-lacks = Not real time: missing { $what }
ticks-rate = Ticks: { $rate } per second
ticks-counts = Missed { $missed }, late { $late }, allocations { $allocations }, page faults { $faults }
ticks-wake = Wake-up delay: 99 % within { $most } µs, longest { $worst } µs
ticks-tick = Tick: 99 % within { $most } µs, longest { $worst } µs
ticks-wake-name = Wake-up delay
ticks-tick-name = Duration of a tick
ticks-bars = { $name }, 1 µs to 33 ms, each bar twice the previous one
lacks-fifo = SCHED_FIFO
lacks-locked = locked memory
lacks-core = a core of its own
gates = Safety chain: intervened { $count } times
gate = { $count } × { $what }
gate-bad-sample = readings ignored: invalid, or outside the workspace
gate-speed-trip = switched off: the handle moved too fast
gate-bad-force = no force: its value was invalid
gate-not-enabled = no force: nobody has enabled it
gate-lost-device = switched off: the device was disconnected
gate-stale-device = faded out: the device was delayed
gate-ramped = ramped: after enabling, or during a pause
gate-stiffness-capped = softened to the stiffness that the device renders stably
gate-damped = damped: the contact fed energy to the hand
gate-clamped = limited to the device's peak force
gate-thermal-limited = reduced: the motors are warm
gate-slewed = smoothed: the force changed too fast

## Faults that switch off the force or the current
fault-no-number = the force was invalid: it is off
fault-late = the haptic device is delayed: the force fades out
fault-gone = the haptic device is disconnected: the force is off
fault-fast = the handle moved too fast: the force is off until enabled (F)
fault-silent = the haptic device sends no valid sample: the force is off
fault-frozen = the haptic device repeats one position: the force is off
fault-clock = the haptic device's clock is wrong: the force is off
fault-bundles = the haptic device's samples come in bundles: the force is off
fault-deaf = the haptic device confirms no force: the force is off
fault-pedal = the foot pedal is disconnected: it counts as released
fault-held = a pedal is held down: release it once
fault-device = the haptic device reports a fault: the force is off
fault-watchdog = the haptic device got no force in time and dropped it
fault-both = cut and coagulate pressed together: no current
unrest-falls = the { $organ } falls: the scene does not hold it
unrest-buried = the instrument is inside the { $organ }: draw it out
unrest-shakes = the { $organ } shakes: the scene is at fault, not you

## Refused requests
command-not-done = Not possible: { $what }. { $why }
command-pause = pause or resume
command-start = restart the task
command-reset = reset the organs
command-force = enable or disable the force
command-instrument = change the instrument
command-seek = go to another moment
command-speed = change the speed
command-other = the command
refused-unknown = The controller does not know this command; its version may differ.
refused-range = The controller does not offer that.
refused-busy = The controller is busy: try again.
refused-otherwise = The controller refused (answer { $answer }).
service-no-answer = The controller does not respond: is the station running?
service-other-version = A process of a different version runs on this station: stop it.
hand-elsewhere = The expert or another display controls the instrument. Release it in the other display (M), or wait.
hand-nobody = No simulated instrument is available: it belongs to a real device, or the station is not running.

## The launcher
launcher-start = Start
launcher-running = Operation
launcher-debrief = Debrief
launcher-questions = Questionnaire
launcher-sheet = Instructor's assessment
launcher-failed = Operation did not start

## Start
start-title = Choose a task
start-begin = Begin (Enter)
start-watch = Watch the expert (W)
who-expert = The expert (a scripted surgeon)
start-trainee = Trainee
start-nobody = Guest (not saved)
start-new-name = New name (N)
start-not-kept = Guest sessions are not saved: choose or enter a name to save yours.
start-kept = Saved in { $store }
start-task = Task
start-asks-identify = Dissect Calot's triangle and the lower third of the gallbladder with the hook, until only the cystic duct and artery enter the gallbladder.
start-asks-clamp = Close the cystic duct and artery with enough well-spaced clips, and clip nothing else.
start-asks-cut = Divide the duct and the artery with scissors, each between its clips.
start-asks-disconnect = Dissect the gallbladder off the liver bed with the hook, without opening either organ.
start-asks-full = All four tasks in order, from the first touch to the freed gallbladder.
start-asks-free = No goal is set; everything is measured.
start-asks-scope = Show one organ after another with the endoscope, level and steady.
start-own-sutures = Place the stay sutures of the gallbladder myself
start-difficulty = Guidance
start-scope = Endoscope
start-scene = Scene
scene-triangle = Calot's triangle
scene-triangle-variant = Calot's triangle, anatomical variant
scene-built-in = Liver and gallbladder
start-devices = Devices
start-emulated = Simulated
start-by-file = From a station file
start-station-file = Station file
start-device-emulated = { $device }: simulated
start-device-there = { $device }: { $path } connected
start-device-missing = { $device }: { $path } not found. Plug it in, or choose simulated devices
start-device-named = { $device }: { $path }, checked at the start
start-hand = Press M to control the instrument with mouse and keyboard; until then it rests.
start-nothing-plugged-in = No serial device or pedal is connected.
start-plugged-in = Connected: { $list }
start-no-file = Enter a station file, or choose simulated devices.

difficulty-beginner = Beginner
difficulty-beginner-gives = Hints tell you the next step; alarms and progress are shown.
difficulty-trainee = Trainee
difficulty-trainee-gives = Alarms and progress are shown.
difficulty-exam = Exam
difficulty-exam-gives = Only time and task are shown; errors are shown at the end.
start-no-folder = { $path }: { $problem }. Choose another folder with --sessions.
start-no-process = The operation did not start: { $problem }

## The store of trainees, and station files
store-no-home = No home folder was found: choose the store's file with --store.
store-io = { $path }: { $problem }. Choose another file with --store.
store-missing = There is no store at { $path } yet.
store-same = { $path } is the store itself and cannot be merged into itself. Choose another file with --store.
store-foreign = { $path } is not a Calot store and was left unchanged. Choose another file with --store.
store-version = { $path } is a store of version { $problem }, from a different Calot, and was left unchanged. Use that Calot, or choose another file with --store.
store-damaged = { $path } is damaged ({ $problem }) and was left unchanged. Restore a copy, or move it away to start afresh.
store-busy = { $path } is in use: another program is writing to it. Try again later.
store-log = { $path } has a log file ({ $problem }) that another program keeps open. Nobody was deleted: close the programs that use it, and try again.
store-sqlite = { $path }: { $problem }
store-no-trainee = The store has no trainee called '{ $name }'.
store-no-session = The session is not in the store.
store-taken = The session is stored under another name.
store-forgotten = The session belongs to somebody who was forgotten after it began, and stays out. A new session is kept.
store-value = { $value } is out of range.
store-questions = Questionnaire: { $problem }
store-sheet = Scoring sheet: { $problem }
store-rated = The rater '{ $rater }' already filled the sheet '{ $sheet }' for the session { $session }, and it stays.
store-alike = '{ $name }' looks like '{ $known }', who is in the store. Choose that name, or one that cannot be confused with it.
store-name = { $name } cannot be used as a name: enter 1 to 64 visible characters.
station-file-none = { $path } is not a station file but a folder, a pipe or a device. Choose a text file (TOML) that lists the devices.
station-file-unread = { $path } cannot be read: { $problem }
station-file-wrong = { $path }, line { $line }: { $problem }

## While an operation runs
running-title = Operation in progress
running-ending = Ending the operation
running-note = The operation has its own window; press Esc there to end it. The debrief then appears here.
running-stop = Stop (S)
running-stop-at-once = Stop now, without a report (S)

## Nothing to debrief
failed-title = The operation did not take place
failed-status = The station stopped: { $status }
failed-note = These are its last messages. Fix the problem, or change your choices.
failed-again = Try again (Enter)
failed-emulated = Try with simulated devices
failed-quit = Quit
failed-code = with code { $number }
failed-signal = on signal { $number }
failed-recorded = The recording is intact: calot store add NAME '{ $path }'

## Debrief
debrief-again = Again (Enter)
debrief-own-turn = Your turn (Enter)
debrief-another = Another task (Esc)
debrief-report = Open the full report (R)
debrief-questions = Questionnaire (Q)
debrief-sheet = Instructor's assessment (I)
debrief-answered = Questionnaire: completed
debrief-sheet-points = Instructor's assessment: { $points } of 25
debrief-errors = Errors
debrief-no-errors = None.
debrief-past = Earlier sessions
debrief-no-past = No earlier session to compare with.
debrief-metrics = Results
debrief-report-opened = The report was opened: { $path }
debrief-report-lies = The report is in { $path }; no program opened it ({ $problem }).
metric = Metric
metric-now = Now
metric-rule = To pass
metric-best = Best so far
sheet-not-whole = Rate all five items.

## Points from 1 to 5
points-about = Trainee: { $name }
points-number = { $number } of { $of }
points-scale = 1: lowest. 5: highest. Press a key from 1 to 5.
points-all = All items are answered:
points-keep = Save (Enter)
points-previous = Previous item (Backspace)
points-back = Back without saving (Esc)

question-anatomy = How realistic is the anatomy?
question-triangle = How realistic is identifying Calot's triangle?
question-interface = How realistic is the picture?
question-instruments = How realistic is the handling of the instruments?
question-electric-dissection = How realistic is the electrosurgical dissection?
question-removal = How realistic is the removal of the gallbladder?
question-laparoscopy = How realistic is it compared with conventional laparoscopy?
question-force-quality = How good is the force feedback?
question-force-use = How useful is the force feedback?
question-hand-eye = How useful is it for training hand-eye coordination?
question-both-hands = How useful is it for training both hands?
question-notes-skills = How useful is it for the basic skills of natural orifice surgery?
question-measures = How much do you trust its performance metrics?
question-other-coordination = How certain are you that hand-eye coordination differs from the two-port technique?

goals-depth = Depth perception: 1 overshoots and corrects slowly, 5 goes straight to the target
goals-hands = Bimanual dexterity: 1 uses one hand only, 5 uses both hands for the best exposure
goals-efficiency = Efficiency: 1 uncertain, many attempts, 5 confident, safe and direct
goals-tissue = Tissue handling: 1 rough, tears and injures, 5 gentle, without injury
goals-autonomy = Autonomy: 1 unable to proceed even with guidance, 5 works independently

## Metrics
metric-score = Score
metric-time-s = Time
metric-gaps-s = Gaps in the recording
metric-paused-s = Time paused
metric-device-lost-s = Time without a device
metric-noise-mm = Noise of the handle at rest
metric-restarts = Restarts
metric-lost-events = Lost events
metric-path-m = Instrument path
metric-scope-path-m = Endoscope path
metric-movements = Instrument movements
metric-scope-movements = Endoscope movements
metric-economy = Economy of movement
metric-smoothness = Smoothness
metric-scope-smoothness = Smoothness of the endoscope
metric-both-moving = Both hands moving
metric-idle-s = Idle time
metric-force-max-n = Peak force
metric-force-mean-n = Mean force
metric-force-p95-n = Force, 95th percentile
metric-force-saturated-s = Time at the device's limit
metric-cautery-on-s = Current on
metric-cautery-air-s = Current without contact
metric-burn-wrong-j = Energy into protected structures
metric-burn-liver-j = Energy into the liver
metric-burn-gallbladder-j = Energy into the gallbladder
metric-burn-duct-j = Energy into ducts
metric-burn-vessel-j = Energy into arteries
metric-burn-target-j = Energy into fat and connective tissue
metric-touches = Protected structures touched
metric-touches-wrong = Hard presses on protected structures
metric-burns-wrong = Protected structures burnt
metric-cuts-wrong = Protected structures cut
metric-clips-used = Clips used
metric-clips-lost = Clips lost
metric-clips-misplaced = Clips misplaced
metric-clips-duct = Clips on the cystic duct
metric-clips-artery = Clips on the cystic artery
metric-clip-spacing-mm = Smallest clip spacing
metric-cuts-one-sided = Divided outside the clips
metric-unclamped = Not closed by clips
metric-injuries = Injuries
metric-blood-ml = Blood loss
metric-bile-ml = Bile loss
metric-perforations = Perforations
metric-crushes = Tissue crushed
metric-tears = Tissue torn
metric-slips = Tissue slipped from the jaws
metric-out-of-view-s = Instrument out of view
metric-scope-turn-deg = Endoscope rotation
metric-scope-tilt-deg = Horizon tilt
metric-scope-sway-mm-s = Sway of the held picture
metric-exchanges = Instrument changes
metric-cvs-triangle = Triangle cleared
metric-cvs-bed = Lower third dissected
metric-cvs-two = Only two structures
metric-views-held = Critical views held
metric-bed = Bed cleared
metric-alarms = Alarms

## Instructor
observe-title = Instructor: station '{ $station }'
observe-no-task = No task: free work without assessment
observe-difficulty = Guidance: { $difficulty }
observe-metrics = Metrics so far
observe-alarms = Alarms
observe-no-alarms = None yet

## The engineering view
inside-counts = { $spheres } spheres, { $links } links, { $tetrahedra } tetrahedra; { $touched } spheres touched
inside-asleep = All { $organs } organs are asleep
inside-awake = Awake { $awake } of { $organs }: { $names }
inside-legend = Spheres: grey asleep, blue awake, white fixed, orange touched, pink grasped.
    Cyan: instrument; magenta: position of the hand; yellow: force, 2 cm per newton.

## Organs, by their names in scenes
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

## Texts of the assessment: steps, hints, reasons
reason-not-done = not done: { $step }
hint-hold = { $step }: keep it in the middle of the picture.
hint-take = { $step }: take the { $instrument } ({ $key }).
hint-grasper = { $step }: touch it, press the pedal, draw the thread to the abdominal wall, press again.
hint-hook = { $step }: hook a strand, lift it clear, then give a short burst of current.
hint-clip-applier = { $step }: pass both jaws around it, keep the tips in view, then close.
hint-scissors = { $step }: see both clips before you close the blades.
step-hang = Suspend the gallbladder with { $count } sutures
step-triangle = Clear Calot's triangle
step-lower-bed = Free the lower third of the gallbladder from its bed
step-view-front = Show the critical view from the front, and hold it
step-view-behind = Show the critical view from behind, and hold it
step-leave-whole = Keep cystic duct and artery intact
step-clip = Place { $count } clips on the { $organ }
step-divide = Divide the { $organ } between clips
step-free = Free the gallbladder from the liver
step-show = Show the { $organ }
hold-on = Hold it
hold-lacks-side = Look from the other side of duct and artery
hold-lacks-triangle = Show more of the cleared triangle
hold-lacks-lower-bed = Show more of the freed bed
hold-lacks-two = Show both duct and artery
hold-lacks-out-of-view = Bring more of it into the picture
hold-lacks-hidden = Something is in front of it
hold-lacks-aside = Bring it to the middle
hold-lacks-small = Go closer
hold-lacks-sway = Hold the picture still
hold-lacks-tilt = Level the horizon
reason-unclamped = clips do not close the { $organ }
reason-injured-divided = the { $organ } was divided
reason-injured-perforated = the wall of the { $organ } was opened
reason-injured-burnt = the { $organ } was burnt more than its wall survives
reason-not-whole = the cystic duct or artery is no longer intact
reason-too-long = it took longer than { $limit }
reason-too-little = { $metric }: { $value }, at least { $limit } required
reason-too-much = { $metric }: { $value }, at most { $limit } allowed
hint-instrument-grasper = grasper
hint-instrument-hook = cautery hook
hint-instrument-clip-applier = clip applier
hint-instrument-scissors = scissors

## Testing a haptic device by hand: `calot devices feel --window`
feel-part-move = Move
feel-part-push = Push
feel-part-opening = Opening
feel-part-scale = Scale
feel-part-response = Response
feel-part-done = { $part }: done
feel-part-now = { $part }: { $number } of { $of }
feel-waiting = The test begins …
feel-move = Move the handle { $mm } mm { $way }
feel-way-right = to the right
feel-way-left = to the left
feel-way-up = up
feel-way-down = down
feel-way-towards = towards you
feel-way-away = away from you
feel-move-note = Hold it still first. Then move it, hold it still there, and press Enter. Measure the way with a ruler: the numbers and the point here come from the device under test.
feel-port-move = An instrument in a port: begin with it half drawn out. It swings about the port while its handle moves; only the way of the handle counts.
feel-port-draw = An instrument in a port: draw the instrument out along its shaft, as far as that leads { $way }, and tilt it for the rest. Only the way of the handle counts.
feel-port-hold = An instrument in a port: hold it half drawn out, so that it can slide both ways.
feel-port-pushed = An instrument in a port: answer by the way of its handle. A push that draws it out goes up or towards you, one that pushes it in goes down or away.
feel-port-scale = An instrument in a port: draw it out so far that the scale fits under its handle, and set the handle down on it.
feel-hold = Hold the handle loosely in the middle of its workspace
feel-hold-note-push = Then press Enter. It will push gently for a second. Feel which way.
feel-hold-note-response = Then press Enter. It will push gently to and fro for 9 s.
feel-push = It pushes with { $newton } N …
feel-push-note = Force and handle are hidden here, because only your hand can tell.
feel-ask-pushed = Which way did it push?
feel-answer-right = Right (R)
feel-answer-left = Left (L)
feel-answer-up = Up (U)
feel-answer-down = Down (D)
feel-answer-towards = Towards you (T)
feel-answer-away = Away (A)
feel-answer-nothing = Nothing felt (N)
feel-shut = Shut the handle fully
feel-open = Open the handle fully
feel-ends-note = Hold it there and press Enter.
feel-hold-fingers = Hold the handle half open with loose fingers
feel-push-fingers = It pushes your fingers with { $newton } N …
feel-ask-fingers = Which way did it push your fingers?
feel-answer-open = Open (O)
feel-answer-shut = Shut (S)
feel-ask-scale = Is there a kitchen scale at hand?
feel-ask-scale-note = The handle would press on it with half a newton: the weight of 51 g.
feel-yes = Yes (Y)
feel-no = No (N)
feel-scale = Stand the handle's tip on the scale
feel-scale-note = Set the scale to zero. Then press Enter.
feel-press = It presses down with { $newton } N. Read the scale
feel-press-note = Press Enter once you have read it. The force ends then.
feel-ask-pressed = What did the scale show?
feel-ask-pressed-note = Type the grams and press Enter. Leave the field empty if you could not read it.
feel-grams-wrong = This is no weight in grams, such as 51.5.
feel-take = Take it (Enter)
feel-response = It pushes to and fro for 9 s …
feel-response-note = Hold it loosely.
feel-done = Done (Enter)
feel-stop = Stop: no force (Esc)
feel-close = Close (Enter)
feel-passed = The device passed
feel-failed = The device did not pass
feel-check-ok = ok
feel-check-fail = failed
feel-check-open = not judged
feel-check-skipped = left out
feel-terminal = The terminal has this list, too.
feel-position = Position, mm
feel-velocity = Velocity, mm/s
feel-force = Force, N
feel-opening = Opening, %
feel-opening-force = Force that opens, N
feel-x = right
feel-y = up
feel-z = towards you
feel-axis-x = right (x)
feel-axis-y = up (y)
feel-axis-z = towards you (z)
feel-hidden = hidden
feel-none = none yet
feel-outside = The device says it is farther away than this picture shows.
