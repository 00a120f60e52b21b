//! A theatre without processes: the simulation alone, faster than real time, with the assessment of
//! the result.

use std::collections::VecDeque;

use assess::{Anatomy, Assessed, Assessment, Difficulty, Rules, Task};
use rt_process::rehearsal::{Rehearsal, rehearse};
use scene_prepare::patient::Patient;
use scene_prepare::{Recipe, prepare};
use session::identity::Identity;
use session::{Entry, EntryContent, Movement};
use shared_mem::inputs::{InputRecord, RunSetup};
use shared_mem::message::{CommandMsg, HandMsg};
use shared_mem::scene::SceneFile;
use shared_mem::words::EventKind;
use surgeon::{Seen, Surgeon, Theatre, operate};

/// Ticks between two looks.
const LOOK_EVERY: u64 = 8;
/// Looks between two identity images: five images a second.
const SEEN_EVERY: u64 = 25;

/// A run of a scripted surgeon, and its assessment.
pub(crate) struct Performance {
    pub(crate) assessed: Assessed,
    /// Number of ticks that the run took.
    pub(crate) ticks: u64,
    /// Hash over the results of all ticks.
    pub(crate) hash: u64,
    /// Messages of the surgeon.
    pub(crate) said: Vec<String>,
    /// Reports of shaking organs. Only a patient may have any: her hepatic artery shakes when it
    /// hangs free.
    pub(crate) shakes: u32,
    /// The setup, and the inputs of each tick.
    pub(crate) recorded: (RunSetup, Vec<InputRecord>),
}

struct Alone<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    assessment: Assessment,
    command: Option<CommandMsg>,
    ticks_max: u64,
    watch: &'a mut dyn FnMut(&Seen, &Assessment),
    said: Vec<String>,
    shakes: u32,
    /// Views not delivered yet, the oldest first.
    unseen: VecDeque<Seen>,
    /// Delay of each view, s.
    late_s: f64,
    /// Changes the recorded movement of the hands at a time, s.
    spoil: &'a dyn Fn(f64, &mut Movement),
    identity: Identity,
    /// Angle between view and shaft, and the view's turn about the shaft, rad.
    sight_rad: [f32; 2],
}

impl Alone<'_, '_> {
    fn note(&mut self, what: EntryContent) {
        let (tick, at_ns) = (self.rehearsal.ticks(), self.rehearsal.ticks() * 1_000_000);
        self.assessment.take(&Entry { tick, at_ns, what });
    }
}

impl Theatre for Alone<'_, '_> {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        for _ in 0..LOOK_EVERY {
            self.rehearsal.tick(asked, self.command.take());
        }
        let mut now = Seen {
            at_s: self.rehearsal.ticks() as f64 * 1e-3,
            state: Box::new(*self.rehearsal.state()),
            tools: Box::new(*self.rehearsal.tools()),
            events: self.rehearsal.events(),
        };
        for event in &now.events {
            self.shakes += u32::from(event.is(EventKind::Shake));
            let (tick, at_ns, what) = (event.tick, event.at_ns, EntryContent::Event(*event));
            self.assessment.take(&Entry { tick, at_ns, what });
        }
        if let Some(mut moved) = Movement::of(&now.tools) {
            (self.spoil)(now.at_s, &mut moved);
            self.note(EntryContent::Moved(moved));
        }
        if (self.rehearsal.ticks() / LOOK_EVERY).is_multiple_of(SEEN_EVERY)
            && let Some(seen) = self.identity.look(self.sight_rad, &now.state, &now.tools)
        {
            self.note(EntryContent::Seen(seen));
        }
        (self.watch)(&now, &self.assessment);
        let at_s = now.at_s;
        now.at_s += self.late_s;
        self.unseen.push_back(now);
        let mut events = Vec::new();
        while self.unseen.front().is_some_and(|first| first.at_s <= at_s) {
            if let Some(mut first) = self.unseen.pop_front() {
                events.append(&mut first.events);
                *seen = first;
            }
        }
        // Events come late with their view. The clock is always current.
        seen.events = events;
        seen.at_s = at_s;
        !self.assessment.is_over() && self.rehearsal.ticks() < self.ticks_max
    }

    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        self.command = Some(command);
        Ok(())
    }

    fn look_off(&mut self, sight_rad: [f32; 2]) -> bool {
        self.sight_rad = sight_rad;
        let [off_rad, turned_rad] = sight_rad;
        self.note(EntryContent::Sight {
            off_rad,
            turned_rad,
        });
        true
    }

    fn tell(&mut self, what: &str) {
        self.said.push(what.to_owned());
    }
}

/// Bytes of Calot's triangle, prepared anew.
pub(crate) fn triangle_bytes() -> Vec<u8> {
    let recipe = Recipe::triangle(false).expect("a built-in recipe");
    let prepared = prepare(&recipe, &mut |_| {}).expect("it can be built");
    prepared.scene.to_bytes().expect("a sound scene")
}

/// The phantom, prepared anew.
pub(crate) fn phantom() -> SceneFile {
    let recipe = Recipe::phantom().expect("a built-in recipe");
    let prepared = prepare(&recipe, &mut |_| {}).expect("it can be built");
    SceneFile::from_bytes(&prepared.scene.to_bytes().expect("a sound scene")).expect("it reads")
}

/// The scene of a patient, by her name or seed, prepared anew.
pub(crate) fn patient(word: &str) -> SceneFile {
    let recipe = Patient::of_word(word).and_then(|patient| patient.recipe());
    let prepared = prepare(&recipe.expect("a recipe"), &mut |_| {}).expect("it can be built");
    SceneFile::from_bytes(&prepared.scene.to_bytes().expect("a sound scene")).expect("it reads")
}

/// Number of the start of a task in `CommandMsg::START`; `None`: the organs begin at rest.
pub(crate) fn start(task: Task) -> Option<u8> {
    let start = [Task::Identify, Task::Clamp, Task::Cut, Task::Disconnect];
    let start = start.iter().position(|it| *it == task)?;
    Some(start as u8 + 1)
}

/// Lets a surgeon perform a task from this start for at most `seconds`. The surgeon sees everything
/// `late_s` late. `watch` sees the state without delay.
pub(crate) fn work(
    start: Option<u8>,
    surgeon: Surgeon,
    task: Task,
    scene: &SceneFile,
    [seconds, late_s]: [f64; 2],
    watch: &mut dyn FnMut(&Seen, &Assessment),
) -> Performance {
    let times_s = [seconds, late_s];
    work_with(start, surgeon, task, scene, times_s, watch, &|_, _| {})
}

/// Works as [`work`] does. `spoil` changes the recorded movement of the hands at a time, s.
pub(crate) fn work_with(
    start: Option<u8>,
    surgeon: Surgeon,
    task: Task,
    scene: &SceneFile,
    [seconds, late_s]: [f64; 2],
    watch: &mut dyn FnMut(&Seen, &Assessment),
    spoil: &dyn Fn(f64, &mut Movement),
) -> Performance {
    let bytes = scene.bytes().to_vec();
    let own = SceneFile::from_bytes(&bytes).expect("a sound scene");
    let rules = Rules::default();
    let assessment = Assessment::new(task, Difficulty::Exam, rules, Anatomy::of(scene));
    let result = rehearse(scene, |rehearsal| {
        let mut alone = Alone {
            rehearsal,
            assessment,
            command: None,
            ticks_max: (seconds * 1e3) as u64,
            watch,
            said: Vec::new(),
            shakes: 0,
            unseen: VecDeque::new(),
            late_s,
            spoil,
            identity: Identity::of(scene),
            sight_rad: [0.0; 2],
        };
        if let Some(task) = start {
            alone.command = Some(CommandMsg {
                kind: CommandMsg::START,
                argument: task.into(),
            });
            alone.note(EntryContent::Start { task });
        }
        operate(surgeon, task, own, &mut alone).expect("a controller");
        Performance {
            assessed: alone.assessment.end(),
            ticks: alone.rehearsal.ticks(),
            hash: alone.rehearsal.hash(),
            recorded: (alone.rehearsal.setup(), alone.rehearsal.records()),
            said: alone.said,
            shakes: alone.shakes,
        }
    });
    let result = result.expect("the core takes it");
    let is_patient = scene.name().starts_with(scene_prepare::patient::PREFIX);
    assert!(is_patient || result.shakes == 0, "no organ shakes");
    result
}
