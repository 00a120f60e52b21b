//! Suturing: the surgeon places the trainee's sutures at the points given by the scene.

use shared_mem::message::SutureMsg;
use shared_mem::words::Instrument;

use crate::plan::COAGULATE;
use crate::sight::Place;
use crate::vector::{Vec3, wide};
use crate::work::Work;

/// Distance in front of the organ at which a stitch begins, m.
const BEFORE_M: f64 = 0.03;
/// Distance that the thread is carried towards the wall, m. A longer distance fixes the thread's
/// direction better.
const CARRIED_M: f64 = 0.06;
/// Duration of a pedal press, and of the pause after it, s.
const STEP_S: f64 = 0.15;
/// A stitch is given up after this time, s.
const GIVE_UP_S: f64 = 6.0;
/// Number of attempts at a stitch whose needle meets nothing.
const TRIES: usize = 3;

impl Work<'_> {
    /// True if a suture remains to be placed.
    pub(crate) fn must_hang(&self) -> bool {
        let sutures = self.seen.state.sutures().unwrap_or(&[]);
        sutures.iter().any(|it| it.placed == SutureMsg::AWAY)
    }

    /// Places every suture that is not placed yet.
    pub(crate) fn hang(&mut self) -> Result<(), String> {
        if !self.seen.tools.has(Instrument::Grasper) {
            self.take(Instrument::Grasper)?;
        }
        for number in 0..self.seen.state.suture_count as usize {
            let given = self.suture(number)?;
            if given.placed == SutureMsg::AWAY {
                self.stitch(number, given.sphere as usize)?;
                self.fasten(number, &given)?;
            }
        }
        Ok(())
    }

    fn suture(&self, number: usize) -> Result<SutureMsg, String> {
        let sutures = self.seen.state.sutures().unwrap_or(&[]);
        (sutures.get(number).copied()).ok_or_else(|| format!("there is no suture {number}"))
    }

    /// Stitches the organ at a sphere, straight in from the port, so that its neighbours stay in
    /// place.
    fn stitch(&mut self, number: usize, sphere: usize) -> Result<(), String> {
        let port = self.sight.port();
        let before = |work: &Self| {
            let at = work.sight.now(sphere, &work.seen.state);
            let out = (port - at).try_normalize(1e-9).unwrap_or_else(Vec3::z);
            Some(Place {
                at: at + out * BEFORE_M,
                along: None,
            })
        };
        for _ in 0..TRIES {
            self.retreat(BEFORE_M)?;
            self.reach(&before, 0.0, false)?;
            let mut before_s = self.seen.at_s;
            let touched = self.look_for(GIVE_UP_S, |work| {
                let seconds = work.seen.at_s - before_s;
                before_s = work.seen.at_s;
                let way = work.sight.now(sphere, &work.seen.state) - work.tip();
                work.go(way * 0.5, seconds.clamp(0.0, STEP_S));
                work.sight.is_touched(sphere, &work.seen.state)
            });
            self.goes_on()?;
            if touched {
                self.step()?;
            }
            if self.suture(number)?.placed == SutureMsg::AT_HAND {
                return Ok(());
            }
        }
        Err(format!("the needle of suture {number} met nothing"))
    }

    /// Carries the thread towards the point of the wall given by the scene.
    fn fasten(&mut self, number: usize, given: &SutureMsg) -> Result<(), String> {
        let sphere = self.suture(number)?.sphere as usize;
        let from = self.sight.now(sphere, &self.seen.state);
        let way = (wide(given.at_m) - from).try_normalize(1e-9);
        let at = from + way.unwrap_or_else(Vec3::z) * CARRIED_M;
        self.reach(&|_| Some(Place { at, along: None }), 0.0, false)?;
        self.step()?;
        match self.suture(number)?.placed {
            SutureMsg::HUNG => Ok(()),
            _ => Err(format!("suture {number} did not reach the wall")),
        }
    }

    fn step(&mut self) -> Result<(), String> {
        self.asked.switches = COAGULATE;
        let pressed = self.wait(STEP_S);
        self.asked.switches = 0;
        pressed?;
        self.wait(STEP_S)
    }
}
