//! Compares the free vibration of a block that is held at one end with beam theory.

use nalgebra::{Matrix2, Vector4};

use super::specimen::Block;
use super::{Bar, Row, work};
use crate::body::{Body, Tissue, V3};
use crate::methods::{Parts, Surroundings};

/// Source of the theory.
const SOURCE: &str = "Timoshenko 1921, 10.1080/14786442108636264";
const BLOCK: Block = Block {
    length_m: 0.120,
    side_m: 0.030,
};
/// Initial amplitude of the tip, m.
const SWING_M: f64 = 1e-3;
/// Simulated time, s.
const SECONDS: f64 = 6.0;
/// Turning points below this share of that amplitude are ignored.
const LEAST: f64 = 1e-3;
/// Largest allowed damping ratio of the solver itself.
const ADDED_MAX: f64 = 0.01;

/// Shear coefficient of a square section (Cowper 1966) with Poisson's ratio ν.
fn shear_coefficient(poisson: f64) -> f64 {
    10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson)
}

/// Vibration, measured at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Swing {
    /// Undamped frequency, Hz.
    frequency_hz: f64,
    /// Rate at which the amplitude decays, 1/s.
    decay_per_s: f64,
}

#[derive(Clone, Copy)]
struct Job {
    young_pa: f64,
    spheres: usize,
    /// True: with the product's viscosity and damping. False: without both.
    is_damped: bool,
}

/// Measures the block's vibration for each material, size and damping.
///
/// # Errors
/// Calot's message if it refuses the block.
pub(super) fn run(quick: bool) -> Result<Vec<Row>, String> {
    let (moduli, sizes): (&[f64], &[usize]) = match quick {
        true => (&[5400.0], &[250]),
        false => (&[5400.0, 15_000.0], &[250, 581, 2500]),
    };
    let mut jobs = Vec::new();
    for young_pa in moduli {
        for spheres in sizes {
            jobs.extend([false, true].map(|is_damped| Job {
                young_pa: *young_pa,
                spheres: *spheres,
                is_damped,
            }));
        }
    }
    let found = work::all(&jobs, |job| rows(job, measure(job)?))?;
    Ok(found.into_iter().flatten().collect())
}

fn tissue(young_pa: f64) -> Tissue {
    Tissue {
        young_pa,
        ..Tissue::LIVER
    }
}

fn rows(job: &Job, swing: Swing) -> Result<Vec<Row>, String> {
    let tissue = tissue(job.young_pa);
    let theory_hz = frequency_hz(&BLOCK, &tissue)?;
    let condition = format!(
        "block 120 x 30 x 30 mm held at one end, E {} kPa, {} spheres, {}",
        job.young_pa / 1e3,
        job.spheres,
        if job.is_damped {
            "damping as shipped"
        } else {
            "no damping asked"
        }
    );
    let row = |quantity: &str, published: f64, calot: f64, bar: Bar| Row {
        source: SOURCE.to_owned(),
        quantity: quantity.to_owned(),
        condition: condition.clone(),
        published,
        published_sd: None,
        calot: Some(calot),
        bar,
    };
    let omega = std::f64::consts::TAU * swing.frequency_hz;
    let asked = match job.is_damped {
        // Drag on the velocity, and viscosity in the tissue.
        true => 0.5 * (tissue.damping_per_s() + tissue.retardation_s() * omega * omega),
        false => 0.0,
    };
    let decay = match job.is_damped {
        true => row(
            "decay of the amplitude, 1/s",
            asked,
            swing.decay_per_s,
            Bar::Percent,
        ),
        false => row(
            "damping ratio that the solver adds",
            0.0,
            swing.decay_per_s / omega,
            Bar::Range(-ADDED_MAX, ADDED_MAX),
        ),
    };
    let frequency = row(
        "natural frequency, Hz",
        theory_hz,
        swing.frequency_hz,
        Bar::Percent,
    );
    Ok(vec![frequency, decay])
}

/// Lets the block vibrate in its first mode.
fn measure(job: &Job) -> Result<Swing, String> {
    let tissue = tissue(job.young_pa);
    let mut body = BLOCK.body(job.spheres, tissue)?;
    let held = std::mem::replace(&mut body.supported, vec![false; body.rest_m.len()]);
    let around = Surroundings {
        gravity_m_s2: V3::zeros(),
        damping_per_s: match job.is_damped {
            true => tissue.damping_per_s() as f32,
            false => 0.0,
        },
    };
    let mut parts = Parts::new(&body, &around, None).map_err(|e| e.to_string())?;
    if !job.is_damped {
        parts = parts.without_viscosity();
    }
    let mut solved = parts.bare().map_err(|e| e.to_string())?;
    let omega = std::f64::consts::TAU * frequency_hz(&BLOCK, &tissue)?;
    let tip: Vec<u32> = at_tip(&body);
    for (i, (x, held)) in (0_u32..).zip(body.rest_m.iter().zip(&held)) {
        let share = mode_share(f64::from(x.x) / BLOCK.length_m);
        let speed = (SWING_M * omega * share) as f32;
        match held {
            true => solved.hold(i, true),
            false => solved.put(i, &V3::zeros(), &V3::new(0.0, 0.0, speed)),
        }
    }
    let mut heights = Vec::new();
    for _ in 0..(SECONDS * 1e3) as usize {
        solved.step();
        let sum: f32 = tip.iter().map(|i| solved.displacement_m(*i).z).sum();
        heights.push(f64::from(sum) / tip.len() as f64);
    }
    let swing = read(&heights)?;
    eprintln!(
        "  E {:.0} Pa, {} spheres, damped {}: {:.3} Hz, {:.4}/s",
        job.young_pa, job.spheres, job.is_damped, swing.frequency_hz, swing.decay_per_s
    );
    Ok(swing)
}

fn at_tip(body: &Body) -> Vec<u32> {
    let all = (0_u32..).zip(&body.rest_m);
    all.filter(|(_, x)| f64::from(x.x) > 0.9 * BLOCK.length_m)
        .map(|(i, _)| i)
        .collect()
}

/// First mode of a slender cantilever at a share of its length, relative to the tip.
fn mode_share(share: f64) -> f64 {
    let (k, bend) = (1.875_104, 0.734_096);
    let (x, at) = (k * share.max(0.0), |x: f64| {
        x.cosh() - x.cos() - bend * (x.sinh() - x.sin())
    });
    at(x) / at(k)
}

/// Computes frequency and decay from the turning points of the tip's height, with one value per
/// millisecond.
fn read(heights: &[f64]) -> Result<Swing, String> {
    // Time and height of each turning point. Consecutive points have opposite signs.
    let mut turns: Vec<(f64, f64)> = Vec::new();
    for (i, three) in heights.windows(3).enumerate() {
        let (before, after) = (three[1] - three[0], three[2] - three[1]);
        let is_next = turns.last().is_none_or(|(_, last)| last * three[1] < 0.0);
        if before * after <= 0.0 && is_next && three[1].abs() > LEAST * SWING_M {
            // The parabola through the three values turns here.
            let curve = before - after;
            let off = match curve.abs() > 0.0 {
                true => 0.5 * (before + after) / curve,
                false => 0.0,
            };
            turns.push(((i as f64 + 1.0 + off) * 1e-3, three[1]));
        }
    }
    let points: Vec<(f64, f64)> = turns.iter().map(|(t, x)| (*t, x.abs().ln())).collect();
    if points.len() < 3 {
        return Err(format!(
            "the block turned {} times in {SECONDS} s; it needs 3 or more turns",
            points.len()
        ));
    }
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (time, log) = (mean(&|p| p.0), mean(&|p| p.1));
    let along: f64 = points.iter().map(|p| (p.0 - time).powi(2)).sum();
    let slope: f64 = points.iter().map(|p| (p.0 - time) * (p.1 - log)).sum();
    let decay_per_s = -slope / along;
    let half_s = (points[points.len() - 1].0 - points[0].0) / (count - 1.0);
    let omega = (std::f64::consts::PI / half_s).hypot(decay_per_s);
    Ok(Swing {
        frequency_hz: omega / std::f64::consts::TAU,
        decay_per_s,
    })
}

/// First natural frequency of a cantilever by Timoshenko's theory, Hz: the lowest one at which
/// bending moment and shear force at the tip are zero.
fn frequency_hz(block: &Block, tissue: &Tissue) -> Result<f64, String> {
    let area = block.side_m * block.side_m;
    let inertia = area * area / 12.0;
    let slender = 3.516 / block.length_m.powi(2)
        * (tissue.young_pa * inertia / (tissue.density_kg_m3 * area)).sqrt();
    let end = |omega: f64| at_end(block, tissue, omega);
    // Shear and rotary inertia lower the frequency of a slender beam.
    let (mut low, mut high) = (0.3 * slender, slender);
    if end(low) * end(high) > 0.0 {
        return Err("beam theory: no frequency in range; correct the block".to_owned());
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match end(low) * end(middle) > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    Ok(0.5 * (low + high) / std::f64::consts::TAU)
}

/// Determinant of the matrix that maps moment and shear at the hold to moment and shear at the tip.
fn at_end(block: &Block, tissue: &Tissue, omega: f64) -> f64 {
    let area = block.side_m * block.side_m;
    let inertia = area * area / 12.0;
    let bending = tissue.young_pa * inertia;
    let shearing = shear_coefficient(tissue.poisson) * tissue.mu() * area;
    let line = tissue.density_kg_m3 * area;
    let turning = tissue.density_kg_m3 * inertia;
    // Deflection, rotation of the section, moment, shear.
    let slope = |s: &Vector4<f64>| {
        Vector4::new(
            s[1] + s[3] / shearing,
            s[2] / bending,
            -s[3] - turning * omega * omega * s[1],
            -line * omega * omega * s[0],
        )
    };
    let steps = 200;
    let h = block.length_m / f64::from(steps);
    let shoot = |mut s: Vector4<f64>| {
        for _ in 0..steps {
            let a = slope(&s);
            let b = slope(&(s + a * (0.5 * h)));
            let c = slope(&(s + b * (0.5 * h)));
            let d = slope(&(s + c * h));
            s += (a + (b + c) * 2.0 + d) * (h / 6.0);
        }
        s
    };
    let moment = shoot(Vector4::new(0.0, 0.0, bending, 0.0));
    let shear = shoot(Vector4::new(0.0, 0.0, 0.0, bending / block.length_m));
    Matrix2::new(moment[2], shear[2], moment[3], shear[3]).determinant()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theory_meets_the_slender_beam_and_lies_below_it_for_a_thick_one() {
        let slender = Block {
            length_m: 3.0,
            side_m: 0.03,
        };
        let tissue = tissue(5400.0);
        let exact = 3.516 / 9.0 * (5400.0 * 0.0009 / 12.0 / 1060.0_f64).sqrt();
        let found = frequency_hz(&slender, &tissue).unwrap();
        assert!((found * std::f64::consts::TAU / exact - 1.0).abs() < 1e-3);
        let thick = frequency_hz(&BLOCK, &tissue).unwrap();
        assert!((0.715..0.735).contains(&thick), "{thick}");
    }

    #[test]
    fn a_damped_sine_is_read() {
        let course: Vec<f64> = (0..6000)
            .map(|i| f64::from(i) * 1e-3)
            .map(|t| 1e-3 * (-0.7 * t).exp() * (4.0 * t).sin())
            .collect();
        let swing = read(&course).unwrap();
        assert!((swing.decay_per_s - 0.7).abs() < 0.005, "{swing:?}");
        let exact = 4.0_f64.hypot(0.7) / std::f64::consts::TAU;
        assert!((swing.frequency_hz / exact - 1.0).abs() < 1e-3);
        assert!(read(&[0.0; 9]).unwrap_err().contains("turned 0 times"));
    }
}
