//! Compares limits, bits and numbers of `rt-core` with those of `shared-mem`. If they differ, this
//! file does not compile.
//!
//! Neither crate depends on the other. Each defines its own limits
//! (`rt_core::capacity`, `shared_mem::limits`); this is the only place that compares them.

use rt_core::capacity;
use rt_core::fault::{FAULT_COUNT, Fault};
use rt_core::sim::Stage;
use rt_core::tool::{Instrument, Role};
use rt_core::words::SphereBits;
use shared_mem::limits;
use shared_mem::message::{SphereState, StateFrame};
use shared_mem::words;

const _: () = {
    assert!(limits::MAX_SPHERES == capacity::MAX_SPHERES);
    assert!(limits::MAX_CELLS == capacity::MAX_CELLS);
    assert!(limits::MAX_CLIPPED == capacity::MAX_CLIPPED);
    assert!(limits::MAX_SUTURES == capacity::MAX_SUTURES);
    assert!(limits::MAX_STONES == capacity::MAX_STONES);
    assert!(limits::MAX_CAPSULES == capacity::MAX_CAPSULES);
    assert!(limits::MAX_DENTS == capacity::MAX_CONTACT_CONSTRAINTS);
    assert!(limits::MAX_TUBE_LINKS == capacity::MAX_TUBE_LINKS);
    let most = capacity::TROCAR_FRICTION_MAX_N;
    assert!(limits::TROCAR_FRICTION_MAX_N.to_bits() == most.to_bits());
    let most = capacity::TROCAR_WALL_MAX_NM_RAD;
    assert!(limits::TROCAR_WALL_MAX_NM_RAD.to_bits() == most.to_bits());
    assert!(limits::STAGES == Stage::ALL.len());
    assert!(limits::FAULTS == FAULT_COUNT);
    assert!(StateFrame::GONE == rt_core::tissue::cells::REMOVED);
    assert!(SphereState::AWAKE == SphereBits::AWAKE.0 as u32);
    assert!(SphereState::CONTACT == SphereBits::CONTACT.0 as u32);
    assert!(SphereState::GRASPED == SphereBits::GRASPED.0 as u32);
    assert!(SphereState::GONE == SphereBits::REMOVED.0 as u32);
    assert!(words::Instrument::Grasper as u8 == Instrument::Grasper as u8);
    assert!(words::Instrument::Hook as u8 == Instrument::Hook as u8);
    assert!(words::Instrument::Scissors as u8 == Instrument::Scissors as u8);
    assert!(words::Instrument::ClipApplier as u8 == Instrument::ClipApplier as u8);
    assert!(words::Instrument::Irrigator as u8 == Instrument::Irrigator as u8);
    assert!(words::CapsuleRole::Shaft as u8 == Role::Shaft as u8);
    assert!(words::CapsuleRole::UpperJaw as u8 == Role::UpperJaw as u8);
    assert!(words::CapsuleRole::LowerJaw as u8 == Role::LowerJaw as u8);
    assert!(words::CapsuleRole::Tip as u8 == Role::Tip as u8);
    let mut i = 0;
    while i < FAULT_COUNT {
        assert!(Fault::ALL[i].code() as u32 == words::Fault::ALL[i].number());
        i += 1;
    }
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_names_the_faults_as_the_core_does() {
        assert_eq!(Fault::ALL.map(Fault::name), words::Fault::NAMES);
    }
}
