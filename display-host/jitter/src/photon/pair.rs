//! Finds for each change of the square the picture and the light that followed.

/// A change of the square, asked for, handed over, or seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Time, ns.
    pub at_ns: u64,
    /// True if the square is bright from now on.
    pub bright: bool,
}

/// A picture that changed the square, once it came to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrived {
    /// Its change, at the time when it came.
    pub change: Change,
    /// Time at which the picture was handed over, ns.
    pub handed_ns: u64,
}

/// Changes that were asked for, with what followed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Times from a change to the picture's handing over, ns.
    pub to_picture_ns: Vec<u64>,
    /// Times from a change to the picture's presentation, ns.
    pub to_presentation_ns: Vec<u64>,
    /// Times from handing over to presentation, ns.
    pub picture_to_presentation_ns: Vec<i64>,
    /// Times from presentation to light, ns; negative if a server stamps the end of a frame.
    pub presentation_to_light_ns: Vec<i64>,
    /// Times from a change to its light, ns.
    pub to_light_ns: Vec<u64>,
    /// Times of the changes whose light was seen, ns.
    pub seen_at_ns: Vec<u64>,
    /// Times from handing over to light, ns; negative if a sensor is quicker than a driver's call.
    pub picture_to_light_ns: Vec<i64>,
    /// Changes whose light was not seen.
    pub unseen: u64,
    /// Changes that came too close to another.
    pub crowded: u64,
    /// True if the sensor says dark where the square is bright.
    pub inverted: bool,
}

impl Pairs {
    /// Changes that count.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.to_light_ns.len() as u64 + self.unseen
    }
}

/// Pairs changes with what followed within `longest_ns`. All are in the order of time.
/// Changes closer together than that cannot be told apart, so they are left out.
#[must_use]
pub fn pair(
    asked: &[Change],
    handed: &[Change],
    arrived: &[Arrived],
    light: &[Change],
    longest_ns: u64,
) -> Pairs {
    let came: Vec<Change> = arrived.iter().map(|it| it.change).collect();
    let [mut plain, inverted] =
        [false, true].map(|it| pair_by(asked, handed, &came, light, longest_ns, it));
    let since = |it: &Arrived| it.change.at_ns as i64 - it.handed_ns as i64;
    plain.picture_to_presentation_ns = arrived.iter().map(since).collect();
    let inverted = Pairs {
        picture_to_presentation_ns: plain.picture_to_presentation_ns.clone(),
        ..inverted
    };
    match inverted.to_light_ns.len() > plain.to_light_ns.len() {
        true => inverted,
        false => plain,
    }
}

fn pair_by(
    asked: &[Change],
    handed: &[Change],
    came: &[Change],
    light: &[Change],
    longest_ns: u64,
    inverted: bool,
) -> Pairs {
    let mut pairs = Pairs {
        inverted,
        ..Pairs::default()
    };
    let follows = |of: &[Change], change: &Change, inverted: bool| {
        let bright = change.bright != inverted;
        let until_ns = change.at_ns + longest_ns;
        let first = of.partition_point(|it| it.at_ns < change.at_ns);
        let mut later = of.get(first..).unwrap_or_default().iter();
        let found = later.find(|it| it.bright == bright)?;
        (found.at_ns < until_ns).then_some(found.at_ns)
    };
    for (i, change) in asked.iter().enumerate() {
        let is_close = |other: Option<&Change>| {
            other.is_some_and(|other| other.at_ns.abs_diff(change.at_ns) < longest_ns)
        };
        let before = i.checked_sub(1).and_then(|i| asked.get(i));
        if is_close(before) || is_close(asked.get(i + 1)) {
            pairs.crowded += 1;
            continue;
        }
        let picture_ns = follows(handed, change, false);
        if let Some(at_ns) = picture_ns {
            pairs.to_picture_ns.push(at_ns - change.at_ns);
        }
        let came_ns = follows(came, change, false);
        pairs
            .to_presentation_ns
            .extend(came_ns.map(|at_ns| at_ns - change.at_ns));
        match follows(light, change, inverted) {
            Some(at_ns) => {
                pairs.to_light_ns.push(at_ns - change.at_ns);
                pairs.seen_at_ns.push(change.at_ns);
                let since = |before_ns: u64| at_ns as i64 - before_ns as i64;
                pairs.picture_to_light_ns.extend(picture_ns.map(since));
                pairs.presentation_to_light_ns.extend(came_ns.map(since));
            }
            None => pairs.unseen += 1,
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const LONGEST_NS: u64 = 400 * MS;

    /// Changes at these times, ms, alternating from bright.
    fn changes(at_ms: &[u64]) -> Vec<Change> {
        let change = |(i, ms): (usize, &u64)| Change {
            at_ns: ms * MS,
            bright: i % 2 == 0,
        };
        at_ms.iter().enumerate().map(change).collect()
    }

    #[test]
    fn each_change_has_its_picture_and_its_light() {
        let asked = changes(&[1000, 1500, 2000, 2500]);
        let handed = changes(&[1010, 1512, 2008, 2511]);
        let light = changes(&[1031, 1530, 2007, 2530]);
        // The last presentation was not reported.
        let arrived = changes(&[1020, 1520, 2020]).into_iter().zip(&handed);
        let arrived: Vec<_> = arrived
            .map(|(change, handed)| Arrived {
                change,
                handed_ns: handed.at_ns,
            })
            .collect();
        let pairs = pair(&asked, &handed, &arrived, &light, LONGEST_NS);
        assert_eq!(pairs.to_picture_ns, [10, 12, 8, 11].map(|ms| ms * MS));
        assert_eq!(pairs.to_presentation_ns, [20; 3].map(|ms| ms * MS));
        let ms = |ns: &[i64]| ns.iter().map(|it| it / 1_000_000).collect::<Vec<_>>();
        assert_eq!(ms(&pairs.picture_to_presentation_ns), [10, 8, 12]);
        assert_eq!(ms(&pairs.presentation_to_light_ns), [11, 10, -13]);
        assert_eq!(pairs.to_light_ns, [31, 30, 7, 30].map(|ms| ms * MS));
        assert_eq!(pairs.picture_to_light_ns[2], -(MS as i64));
        assert_eq!((pairs.unseen, pairs.crowded, pairs.count()), (0, 0, 4));
    }

    #[test]
    fn a_sensor_that_says_dark_for_bright_is_noticed() {
        let asked = changes(&[1000, 1500, 2000]);
        let light: Vec<Change> = changes(&[1031, 1530, 2033])
            .into_iter()
            .map(|it| Change {
                bright: !it.bright,
                ..it
            })
            .collect();
        let inverted = pair(&asked, &[], &[], &light, LONGEST_NS);
        assert!(inverted.inverted && inverted.to_light_ns.len() == 3);
        let plain = pair(&asked, &[], &[], &changes(&[1031, 1530, 2033]), LONGEST_NS);
        assert!(!plain.inverted && plain.to_light_ns.len() == 3);
    }

    #[test]
    fn what_is_close_to_another_or_never_seen_is_counted_apart() {
        let asked = changes(&[1000, 1100, 2000, 3000]);
        // The light of the last comes too late to be its own.
        let light = changes(&[1030, 1130, 2020, 3400]);
        let pairs = pair(&asked, &[], &[], &light, LONGEST_NS);
        assert_eq!(pairs.to_light_ns, [20 * MS]);
        assert_eq!(pairs.seen_at_ns, [2000 * MS]);
        assert_eq!((pairs.unseen, pairs.crowded, pairs.count()), (1, 2, 2));
        assert!(pairs.to_picture_ns.is_empty() && pairs.picture_to_light_ns.is_empty());
    }
}
