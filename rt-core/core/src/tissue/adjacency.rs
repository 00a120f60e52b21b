//! Neighbours of each sphere by links.

use crate::capacity::{MAX_LINKS, MAX_SPHERES};
use crate::scene::Link;
use crate::tissue::per_sphere::PerSphere;

/// Lists of the linked spheres of every sphere, one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Adjacency {
    /// First of each sphere's list in `linked`, and its length.
    list: PerSphere<(u32, u32)>,
    linked: [u16; 2 * MAX_LINKS],
}

impl Adjacency {
    pub(crate) const fn new() -> Self {
        Self {
            list: PerSphere::new((0, 0)),
            linked: [0; 2 * MAX_LINKS],
        }
    }

    /// Builds the lists; done once, when the scene is loaded. O(links).
    pub(crate) fn build(&mut self, links: &[Link]) {
        for i in 0..MAX_SPHERES as u32 {
            *self.list.at_mut(i) = (0, 0);
        }
        for link in links {
            self.list.at_mut(link.a).1 += 1;
            self.list.at_mut(link.b).1 += 1;
        }
        let mut next = 0;
        for i in 0..MAX_SPHERES as u32 {
            let (start, length) = self.list.at_mut(i);
            *start = next;
            next += *length;
            *length = 0;
        }
        for link in links {
            self.append(link.a, link.b);
            self.append(link.b, link.a);
        }
    }

    fn append(&mut self, of: u32, linked: u32) {
        let (start, length) = self.list.at_mut(of);
        if let Some(slot) = self.linked.get_mut((*start + *length) as usize) {
            *slot = linked as u16; // sphere indices fit: asserted in `capacity`
            *length += 1;
        }
    }

    /// The spheres that sphere `i` is linked to.
    #[inline]
    pub(crate) fn of(&self, i: u32) -> &[u16] {
        let (start, length) = *self.list.at(i);
        self.linked
            .get(start as usize..(start + length) as usize)
            .unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::boxed::Box;

    #[test]
    fn lists_are_symmetric_and_rebuilt() {
        let link = |a, b| Link {
            a,
            b,
            rest_length_m: 1.0,
            compliance_m_n: 0.0,
        };
        let mut adjacency = Box::new(Adjacency::new());
        adjacency.build(&[link(0, 1), link(1, 2)]);
        assert_eq!(adjacency.of(0), [1]);
        assert_eq!(adjacency.of(1), [0, 2]);
        assert_eq!(adjacency.of(2), [1]);
        assert!(adjacency.of(3).is_empty());
        adjacency.build(&[link(3, 2)]);
        assert!(adjacency.of(0).is_empty());
        assert_eq!(adjacency.of(3), [2]);
    }
}
