//! One value per sphere, without a bounds check and without a panic.

use crate::capacity::MAX_SPHERES;

const _: () = assert!(
    MAX_SPHERES.is_power_of_two(),
    "an index is kept in range by a mask"
);

/// One `T` per sphere of the scene, in the scene's order.
#[derive(Debug, Clone)]
pub(crate) struct PerSphere<T>([T; MAX_SPHERES]);

impl<T: Copy> PerSphere<T> {
    /// `value` for every sphere.
    pub(crate) const fn new(value: T) -> Self {
        Self([value; MAX_SPHERES])
    }

    /// Value of sphere `i`. [`crate::scene::Scene::new`] has checked every index. The mask shows
    /// the compiler that no index is out of range.
    #[inline(always)]
    pub(crate) fn at(&self, i: u32) -> &T {
        &self.0[i as usize & (MAX_SPHERES - 1)]
    }

    /// Mutable value of sphere `i`.
    #[inline(always)]
    pub(crate) fn at_mut(&mut self, i: u32) -> &mut T {
        &mut self.0[i as usize & (MAX_SPHERES - 1)]
    }

    /// Values of `count` spheres from `start` on.
    pub(crate) fn range(&self, start: u32, count: u32) -> &[T] {
        let (start, count) = (start as usize, count as usize);
        self.0
            .get(start..start.saturating_add(count))
            .unwrap_or(&[])
    }

    /// Mutable values of `count` spheres from `start` on.
    pub(crate) fn range_mut(&mut self, start: u32, count: u32) -> &mut [T] {
        let (start, count) = (start as usize, count as usize);
        self.0
            .get_mut(start..start.saturating_add(count))
            .unwrap_or(&mut [])
    }
}
