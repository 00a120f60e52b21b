//! The player of a run: a person, a scripted surgeon, or the emulated devices' own script.

use hardware::station::StationFile;

use super::args::RunArgs;
use crate::args::GamepadName;
use crate::problem::Problem;

/// Person or program that moves the handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Player {
    /// A person, at a device or at the emulated handle.
    Person,
    /// The scripted surgeon of `--hand`, at the emulated handle.
    Surgeon,
    /// The emulated devices' own script.
    Script,
}

impl Player {
    pub(crate) fn of(args: &RunArgs) -> Result<Self, Problem> {
        let devices = &args.controller.devices;
        let file = devices.station_file.as_deref().map(StationFile::read);
        let is_named = file.transpose()?.is_some_and(|file| file.haptic.is_some());
        let is_emulated = devices.haptic.is_none() && !is_named;
        // In a window or with a named gamepad, a person can lead the emulated handle.
        let is_led = !args.headless || matches!(args.gamepad.gamepad, GamepadName::Path(_));
        match (args.task.hand, is_emulated) {
            (Some(_), true) => Ok(Self::Surgeon),
            (Some(_), false) => Err(NO_HANDLE.into()),
            // Without a task, a window shows the script until somebody takes the handle.
            (None, true) if !is_led || args.task.task.is_none() => Ok(Self::Script),
            (None, _) => Ok(Self::Person),
        }
    }

    /// True if no person works.
    pub(crate) const fn is_scripted(self) -> bool {
        !matches!(self, Self::Person)
    }

    /// Hand of the emulator, as in `calot emulate --hand`. A parked handle rests until somebody
    /// leads it.
    pub(crate) const fn emulated_hand(self) -> &'static str {
        match self {
            Self::Person | Self::Surgeon => "parked",
            Self::Script => "script",
        }
    }
}

/// For haptic device, tracker and pedal: true if it is simulated. A station to which a display
/// attaches has devices that nothing here names.
pub(crate) fn simulated(args: &RunArgs) -> [bool; 3] {
    let named = &args.controller.devices;
    let file = named.station_file.as_deref().map(StationFile::read);
    // A file that cannot be read has stopped the start already.
    let file = file.and_then(Result::ok).unwrap_or_default();
    [
        named.haptic.is_none() && file.haptic.is_none(),
        named.tracker.is_none() && file.tracker.is_none(),
        named.pedal.is_none() && file.pedal.is_none(),
    ]
    .map(|it| it && !args.attach)
}

const NO_HANDLE: &str = "a scripted surgeon moves only an emulated handle: leave out --hand, or the \
                         haptic device (--haptic, or [haptic] in the station file)";

#[cfg(test)]
mod tests {
    use assess::Task;
    use surgeon::Surgeon;

    use super::*;

    fn player(change: fn(&mut RunArgs)) -> Result<Player, Problem> {
        let mut args = RunArgs::default();
        change(&mut args);
        Player::of(&args)
    }

    fn by_gamepad(args: &mut RunArgs) {
        args.headless = true;
        args.task.task = Some(Task::Free);
        args.gamepad.gamepad = GamepadName::Path("/dev/input/event5".into());
    }

    #[test]
    fn a_script_plays_only_where_nobody_could_take_the_handle_for_a_task() {
        let of = |change| player(change).unwrap();
        assert_eq!(of(|_| {}), Player::Script, "no task to play for anybody");
        let in_window = of(|it| it.task.task = Some(Task::Free));
        assert_eq!(in_window, Player::Person);
        assert_eq!(in_window.emulated_hand(), "parked");
        let alone = of(|it| {
            it.headless = true;
            it.task.task = Some(Task::Free);
        });
        assert_eq!(alone, Player::Script);
        assert!(alone.is_scripted());
        let at_device = of(|it| {
            it.headless = true;
            it.controller.devices.haptic = Some("/dev/ttyACM0".into());
        });
        assert!(!at_device.is_scripted());
        assert_eq!(of(by_gamepad), Player::Person);
    }

    #[test]
    fn a_device_is_simulated_unless_it_is_named_or_belongs_to_another_run() {
        let of = |change: fn(&mut RunArgs)| {
            let mut args = RunArgs::default();
            change(&mut args);
            simulated(&args)
        };
        assert_eq!(of(|_| {}), [true; 3]);
        let pedal = of(|it| it.controller.devices.pedal = Some("/dev/input/event3".into()));
        assert_eq!(pedal, [true, true, false]);
        assert_eq!(of(|it| it.attach = true), [false; 3]);
    }

    #[test]
    fn a_scripted_surgeon_works_with_and_without_a_window_but_not_at_a_device() {
        for headless in [false, true] {
            let mut args = RunArgs {
                headless,
                ..RunArgs::default()
            };
            args.task.hand = Some(Surgeon::Careful);
            let player = Player::of(&args).unwrap();
            assert_eq!(player, Player::Surgeon);
            assert!(player.is_scripted());
        }
        let refused = player(|it| {
            it.task.hand = Some(Surgeon::Careful);
            it.controller.devices.haptic = Some("/dev/ttyACM0".into());
        });
        assert!(refused.unwrap_err().to_string().contains("--haptic"));
    }
}
