//! Tests the Inverse3's driver with an emulated service on a loopback socket.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::conformance::{Options, inverse3};
use hardware::emulate::{EmulatedInverse3, ServiceFault};
use hardware::inverse3::Inverse3Haptic;
use rt_core::math::Vec3;
use rt_core::port::{DeviceSample, ForceCommand, HapticDevice, Polled};

use crate::support::poll_for;

const PATIENCE: Duration = Duration::from_secs(20);

fn path(service: &EmulatedInverse3) -> PathBuf {
    PathBuf::from(service.address().to_string())
}

/// Opens the device with retries, because on a busy machine the service may be too slow.
fn open(service: &EmulatedInverse3) -> Inverse3Haptic {
    crate::support::persist(|| Inverse3Haptic::open(&path(service), None))
}

fn push(newtons: f32) -> ForceCommand {
    ForceCommand {
        opening_n: 0.0,
        force_n: Vec3::new(newtons, 0.0, 0.0),
        torque_nm: Vec3::zeros(),
    }
}

/// Sends `command` and polls until `enough`; opens the device anew if it was lost.
fn until(
    service: &EmulatedInverse3,
    device: &mut Inverse3Haptic,
    command: Option<ForceCommand>,
    mut enough: impl FnMut(Polled<DeviceSample>) -> bool,
) -> bool {
    let mut done = false;
    poll_for(PATIENCE, |now_ns| {
        if let Some(command) = command {
            device.send(command, now_ns);
        }
        let polled = device.poll(now_ns);
        done = enough(polled);
        if !done && polled == Polled::Lost {
            *device = open(service);
        }
        !done
    });
    done
}

#[test]
fn the_handle_is_read_and_its_force_is_limited() {
    let service = EmulatedInverse3::start().unwrap();
    let mut device = open(&service);
    let mut strongest = 0.0f32;
    let pushed = until(&service, &mut device, Some(push(100.0)), |polled| {
        strongest = strongest.max(service.force_n().norm());
        matches!(polled, Polled::Fresh(sample)
            if sample.device_from_handle.translation.x > 5e-3)
    });
    assert!(pushed);
    assert!((1.0..5.001).contains(&strongest), "{strongest}");
    let counters = device.counters();
    assert!(
        counters.frames > 0 && counters.bad_frames == 0,
        "{counters:?}"
    );
}

#[test]
fn a_host_that_hangs_or_ends_leaves_no_force() {
    let service = EmulatedInverse3::start().unwrap();
    let mut device = open(&service);
    let felt = |device: &mut Inverse3Haptic| {
        until(&service, device, Some(push(2.0)), |_| {
            service.force_n().norm() > 1.9
        })
    };
    assert!(felt(&mut device));
    assert!(
        until(&service, &mut device, None, |_| service.force_n().norm()
            < 1e-6),
        "nobody sends any more"
    );
    assert!(felt(&mut device));
    drop(device);
    let mut gone = false;
    poll_for(PATIENCE, |_| {
        gone = service.force_n().norm() < 1e-6;
        !gone
    });
    assert!(gone);
}

#[test]
fn samples_are_in_range_whatever_the_service_does_and_the_connection_recovers() {
    for how in [
        ServiceFault::Garbage,
        ServiceFault::Boundless,
        ServiceFault::Stuck,
        ServiceFault::Silent,
        ServiceFault::HangUp,
        ServiceFault::Drip,
    ] {
        let service = EmulatedInverse3::start().unwrap();
        let mut device = open(&service);
        let fresh = |polled| matches!(polled, Polled::Fresh(_));
        assert!(until(&service, &mut device, Some(push(f32::NAN)), fresh));
        assert!(service.force_n().norm() < 1e-6, "NaN is no force");
        service.set_fault(how);
        let lost = matches!(
            how,
            ServiceFault::Silent | ServiceFault::HangUp | ServiceFault::Drip
        );
        let bad = matches!(how, ServiceFault::Garbage | ServiceFault::Boundless);
        let mut shown = false;
        let limit = if how == ServiceFault::Stuck {
            Duration::from_millis(300)
        } else {
            PATIENCE
        };
        poll_for(limit, |now_ns| {
            device.send(push(1.0), now_ns);
            match device.poll(now_ns) {
                Polled::Fresh(sample) => {
                    let at = sample.device_from_handle.translation.vector;
                    assert!(at.norm() <= 0.361, "{how:?}: {at}");
                    assert!(sample.velocity_m_s.unwrap().iter().all(|v| v.is_finite()));
                }
                Polled::Nothing => {}
                Polled::Lost => {
                    shown |= lost;
                    // A busy machine lost the device.
                    if !shown {
                        device = open(&service);
                    }
                }
            }
            shown |= bad && device.counters().bad_frames > 3;
            !shown
        });
        assert!(shown || how == ServiceFault::Stuck, "{how:?}");
        assert!(service.force_n().norm() <= 5.001);
        service.set_fault(ServiceFault::None);
        assert!(
            until(&service, &mut device, Some(push(0.0)), fresh),
            "{how:?}"
        );
    }
}

#[test]
fn the_newest_state_of_a_service_that_sends_too_much_is_used() {
    let service = EmulatedInverse3::start().unwrap();
    let mut device = open(&service);
    service.set_fault(ServiceFault::Flood);
    let mut samples = 0;
    assert!(until(&service, &mut device, Some(push(0.0)), |polled| {
        samples += u32::from(matches!(polled, Polled::Fresh(_)));
        samples > 300
    }));
    let counters = device.counters();
    // The service falls silent. From now on only samples that still wait can come.
    service.set_fault(ServiceFault::Silent);
    let (mut left, mut lost) = (0, false);
    poll_for(PATIENCE, |now_ns| {
        match device.poll(now_ns) {
            Polled::Fresh(_) => left += 1,
            Polled::Nothing => {}
            Polled::Lost => lost = true,
        }
        !lost
    });
    assert!(lost);
    // If the driver read only one answer per command, more than a thousand samples would be left.
    assert!(left < 100, "{left} samples out of the past; {counters:?}");
}

#[test]
fn an_address_without_a_service_is_refused_as_such() {
    let error = Inverse3Haptic::open(Path::new("127.0.0.1:1"), None).unwrap_err();
    assert!(
        error.to_string().contains("haply-inverse-service"),
        "{error}"
    );
    let far = Inverse3Haptic::open(Path::new("192.0.2.1:10001"), None).unwrap_err();
    assert!(far.to_string().contains("this computer"), "{far}");
    let service = EmulatedInverse3::start().unwrap();
    let other = Inverse3Haptic::open(&path(&service), Some("1234")).unwrap_err();
    assert!(other.to_string().contains("no such Inverse3"), "{other}");
    // A server that never sends anything.
    let mute = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = mute.local_addr().unwrap().to_string();
    let error = Inverse3Haptic::open(Path::new(&address), None).unwrap_err();
    assert!(matches!(error, HardwareError::Service { .. }), "{error}");
}

#[test]
fn the_suite_passes() {
    let service = EmulatedInverse3::start().unwrap();
    // A busy machine may spoil the rate for a while.
    let start = Instant::now();
    loop {
        let mut options = Options {
            watch: Duration::from_secs(1),
            unplug: None,
        };
        let report = inverse3(&path(&service), &mut options);
        if report.passed() {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(120), "{report}");
    }
}
