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
scope = Endoscope: { $angle }°, cable turned { $turned }°
scope-next = Next endoscope (S)
scope-left = Turn left ([)
scope-right = Turn right (])
scope-wipe = Wipe lens (W)
scope-dirty = Lens: fogged or sooty, wipe it
scope-held = Camera: held still by the pedal
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
