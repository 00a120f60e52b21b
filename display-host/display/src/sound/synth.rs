//! Synthesis of the sounds as plain functions of time, without recordings or a sound card.

use core::f32::consts::TAU;

/// Pitch of a cutting current, a clear hum, Hz.
const CUT_HZ: f32 = 520.0;
/// Pitch of a coagulating current, which is lower and rough, Hz.
const COAGULATE_HZ: f32 = 330.0;
/// Burst rate of a coagulating current, Hz.
const BURST_HZ: f32 = 27.0;
/// Loudness of the electrode's current.
const ELECTRO_GAIN: f32 = 0.14;
/// Loudness of a clip's click.
const CLICK_GAIN: f32 = 0.22;
/// Loudness of an alarm.
const ALARM_GAIN: f32 = 0.20;
/// Loudness of the heart beep.
const HEART_GAIN: f32 = 0.10;
/// Duration of fading in and out, s. An abrupt change would click.
const RAMP_S: f32 = 0.006;
/// Times at which the beeps of a high-priority alarm begin, s: three, then two (IEC 60601-1-8).
const ALARM_AT_S: [f32; 5] = [0.0, 0.25, 0.50, 0.95, 1.20];
/// Pitches of the alarm's beeps, Hz.
const ALARM_HZ: [f32; 5] = [523.0, 659.0, 784.0, 659.0, 784.0];
/// Duration of one beep of an alarm, s.
const ALARM_BEEP_S: f32 = 0.16;
/// Time after which the alarm's beeps repeat, s.
const ALARM_EVERY_S: f32 = 3.5;
/// Period of the heart beep, s.
const HEART_EVERY_S: f32 = 0.86;
/// Duration of the heart beep, s.
const HEART_BEEP_S: f32 = 0.07;
/// Pitch of the heart beep at a saturation of 98 %, Hz.
const HEART_HZ: f32 = 740.0;
/// Duration of a clip's click, s.
const CLICK_S: f32 = 0.05;

/// Current of the electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Current {
    /// No current.
    #[default]
    Off,
    /// Cutting current.
    Cut,
    /// Coagulating current.
    Coagulate,
}

/// The sounds to hear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heard {
    /// Current of the electrode.
    pub current: Current,
    /// True while an alarm is not acknowledged.
    pub alarm: bool,
    /// True while the heart monitor beeps.
    pub heart: bool,
    /// Number of clips closed so far: each new one clicks.
    pub clips: u8,
}

/// Produces samples from −1 to 1.
#[derive(Debug, Clone)]
pub struct Synth {
    rate_hz: f32,
    heard: Heard,
    /// Levels of cut, coagulation, alarm and heart, moving towards 0 or 1.
    levels: [f32; 4],
    phases: [f32; 4],
    /// Time since the alarm's beeps began or repeated, s.
    alarm_s: f32,
    /// Time since the last heart beep began, s.
    heart_s: f32,
    /// Time since the newest click began, s.
    click_s: f32,
    /// Level of a click that the next click has cut short. The level fades, because an abrupt end
    /// would crackle.
    cut_short: f32,
    /// State of the generator of noise.
    noise: u32,
    /// The last sample of filtered noise.
    rough: f32,
}

impl Synth {
    /// A synthesiser with this many samples a second.
    #[must_use]
    pub fn new(rate_hz: f32) -> Self {
        Self {
            rate_hz: if rate_hz.is_finite() {
                rate_hz.clamp(8e3, 384e3)
            } else {
                48e3
            },
            heard: Heard::default(),
            levels: [0.0; 4],
            phases: [0.0; 4],
            alarm_s: 0.0,
            heart_s: 0.0,
            click_s: CLICK_S,
            cut_short: 0.0,
            noise: 1,
            rough: 0.0,
        }
    }

    /// Sets the sounds from the next sample on.
    pub fn hear(&mut self, heard: Heard) {
        if heard.clips != self.heard.clips {
            self.cut_short += click(self.click_s);
            self.click_s = 0.0;
        }
        if heard.alarm && !self.heard.alarm {
            self.alarm_s = 0.0;
        }
        self.heard = heard;
    }

    /// The next sample.
    pub fn sample(&mut self) -> f32 {
        let step_s = 1.0 / self.rate_hz;
        let wanted = [
            self.heard.current == Current::Cut,
            self.heard.current == Current::Coagulate,
            self.heard.alarm,
            self.heard.heart,
        ];
        for (level, on) in self.levels.iter_mut().zip(wanted) {
            let way = if on { step_s } else { -step_s } / RAMP_S;
            *level = (*level + way).clamp(0.0, 1.0);
        }
        let [cut, coagulate, alarm, heart] = self.levels;
        let mut sum = 0.0;
        if cut > 0.0 {
            let p = self.turn(0, CUT_HZ);
            sum +=
                cut * ELECTRO_GAIN * ((p).sin() + 0.25 * (2.0 * p).sin() + 0.12 * (3.0 * p).sin());
        }
        if coagulate > 0.0 {
            let p = self.turn(1, COAGULATE_HZ);
            let burst = self.turn(2, BURST_HZ).sin().max(0.0);
            let hiss = self.hiss();
            sum += coagulate * ELECTRO_GAIN * (0.45 * p.sin() + (0.35 + 0.9 * burst) * hiss);
        }
        self.alarm_s = (self.alarm_s + step_s) % ALARM_EVERY_S;
        if alarm > 0.0 {
            let t = self.alarm_s;
            for (from, hz) in ALARM_AT_S.into_iter().zip(ALARM_HZ) {
                let since = t - from;
                let loud = beep(since, ALARM_BEEP_S);
                if loud > 0.0 {
                    let p = TAU * hz * since;
                    sum += alarm
                        * ALARM_GAIN
                        * loud
                        * (p.sin() + 0.3 * (2.0 * p).sin() + 0.2 * (3.0 * p).sin());
                }
            }
        }
        self.heart_s = (self.heart_s + step_s) % HEART_EVERY_S;
        if heart > 0.0 {
            let loud = beep(self.heart_s, HEART_BEEP_S);
            sum += heart * HEART_GAIN * loud * (TAU * HEART_HZ * self.heart_s).sin();
        }
        self.cut_short *= (-step_s / RAMP_S).exp();
        sum += self.cut_short + click(self.click_s);
        if self.click_s < CLICK_S {
            self.click_s += step_s;
        }
        sum
    }

    /// Advances a phase by one sample of this pitch. Returns the phase, rad.
    fn turn(&mut self, which: usize, hz: f32) -> f32 {
        let phase = &mut self.phases[which];
        *phase = (*phase + TAU * hz / self.rate_hz) % TAU;
        *phase
    }

    /// Noise without its highest frequencies, −1 to 1.
    fn hiss(&mut self) -> f32 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 17;
        self.noise ^= self.noise << 5;
        let white = (self.noise >> 8) as f32 / 8_388_608.0 - 1.0;
        self.rough += (white - self.rough) * 0.45;
        self.rough
    }
}

/// Sample of a click, `t_s` after the clip closed. The ratchet rings shortly, and the clip's legs
/// ring longer.
fn click(t_s: f32) -> f32 {
    if t_s >= CLICK_S {
        return 0.0;
    }
    let die = |s: f32| (-t_s / s).exp();
    let (ratchet, legs) = ((TAU * 3100.0 * t_s).sin(), (TAU * 1250.0 * t_s).sin());
    let ring = die(0.004) * ratchet + 0.6 * die(0.012) * legs;
    CLICK_GAIN * ring * (1.0 - t_s / CLICK_S) * (t_s / 0.0003).min(1.0)
}

/// Loudness of a beep, `since` seconds after it began.
fn beep(since: f32, lasts_s: f32) -> f32 {
    if (0.0..lasts_s).contains(&since) {
        (since.min(lasts_s - since) / (2.0 * RAMP_S)).min(1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const RATE_HZ: f32 = 48_000.0;

    fn play(heard: Heard, seconds: f32) -> Vec<f32> {
        let mut synth = Synth::new(RATE_HZ);
        synth.hear(heard);
        (0..(seconds * RATE_HZ) as usize)
            .map(|_| synth.sample())
            .collect()
    }

    /// Share of the power near a frequency (Goertzel).
    fn share(samples: &[f32], hz: f32) -> f32 {
        let w = TAU * hz / RATE_HZ;
        let (mut a, mut b) = (0.0f32, 0.0f32);
        for x in samples {
            (a, b) = (x + 2.0 * w.cos() * a - b, a);
        }
        let n = samples.len() as f32;
        let power = (a * a + b * b - 2.0 * w.cos() * a * b) * 2.0 / n;
        power / samples.iter().map(|x| x * x).sum::<f32>().max(1e-9)
    }

    fn electro(current: Current) -> Vec<f32> {
        play(
            Heard {
                current,
                ..Heard::default()
            },
            1.0,
        )[4800..]
            .to_vec()
    }

    #[test]
    fn a_cutting_current_is_a_tone_and_a_coagulating_one_is_rough() {
        let (cut, coagulate) = (electro(Current::Cut), electro(Current::Coagulate));
        assert!(share(&cut, CUT_HZ) > 0.8, "{}", share(&cut, CUT_HZ));
        assert!(
            share(&coagulate, CUT_HZ) < 0.02,
            "{}",
            share(&coagulate, CUT_HZ)
        );
        let tone = share(&coagulate, COAGULATE_HZ);
        assert!(tone > 0.1 && tone < 0.7, "{tone}");
    }

    #[test]
    fn silence_is_silent_and_an_alarm_pauses() {
        assert!(play(Heard::default(), 1.0).iter().all(|x| x.abs() < 1e-9));
        let alarm = play(
            Heard {
                alarm: true,
                ..Heard::default()
            },
            3.4,
        );
        let loud = |from: f32, to: f32| {
            let part = &alarm[(from * RATE_HZ) as usize..(to * RATE_HZ) as usize];
            part.iter().map(|x| x.abs()).fold(0.0, f32::max)
        };
        for at in ALARM_AT_S {
            assert!(loud(at + 0.03, at + 0.13) > 0.1, "beep at {at} s");
        }
        assert!(loud(1.5, 3.3) < 1e-6);
    }

    #[test]
    fn each_clip_clicks_once() {
        let mut synth = Synth::new(RATE_HZ);
        let loudest = |synth: &mut Synth| {
            let part = (0..4800).map(|_| synth.sample().abs());
            part.fold(0.0, f32::max)
        };
        assert!(loudest(&mut synth) < 1e-9);
        let heard = Heard {
            clips: 1,
            ..Heard::default()
        };
        synth.hear(heard);
        assert!(loudest(&mut synth) > 0.05);
        synth.hear(heard);
        assert!(loudest(&mut synth) < 1e-6);
    }

    #[test]
    fn a_click_that_cuts_another_short_does_not_crackle() {
        let mut synth = Synth::new(RATE_HZ);
        let (mut last, mut most) = (0.0f32, 0.0f32);
        for clips in 1..9 {
            synth.hear(Heard {
                clips,
                ..Heard::default()
            });
            for _ in 0..7 {
                let x = synth.sample();
                most = most.max((x - last).abs());
                last = x;
            }
        }
        assert!(most < 0.15, "{most}");
    }

    proptest! {
        #[test]
        fn sounds_neither_clip_nor_crackle(
            changes in proptest::collection::vec((0u8..3, any::<bool>(), any::<bool>(), any::<u8>(), 10usize..4000), 1..12),
            rate_hz in prop_oneof![Just(44_100.0f32), Just(48_000.0), Just(96_000.0)],
        ) {
            let mut synth = Synth::new(rate_hz);
            let mut last = 0.0f32;
            for (current, alarm, heart, clips, samples) in changes {
                let current = [Current::Off, Current::Cut, Current::Coagulate][current as usize];
                synth.hear(Heard { current, alarm, heart, clips });
                for _ in 0..samples {
                    let x = synth.sample();
                    prop_assert!(x.abs() < 0.95, "{x}");
                    // Noise may jump; a tone that begins or ends may not.
                    prop_assert!((x - last).abs() < 0.35, "from {last} to {x}");
                    last = x;
                }
            }
        }
    }
}
