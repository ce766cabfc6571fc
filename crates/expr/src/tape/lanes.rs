//! Unchecked access to operands and results of instructions: the only `unsafe` code of the project.
//!
//! A checked access costs as much as the arithmetic on 64 lanes, and the loss of the step method consists
//! of such accesses. `Tape::compile` guarantees and asserts the conditions for every program: every
//! operand, factor and result is a slot of the program, every factor pair of a chain exists, and no
//! instruction writes a slot that it reads.

#![allow(unsafe_code)]

use std::marker::PhantomData;

/// The memory of one run.
pub(super) struct Lanes<'a, const N: usize> {
    slots: *mut [f64; N],
    factors: *const [u32; 2],
    /// The slots and the factors live as long.
    memory: PhantomData<&'a mut [[f64; N]]>,
}

impl<'a, const N: usize> Lanes<'a, N> {
    /// For a program that needs so many slots and has these pairs of factors.
    ///
    /// # Panics
    /// If there are fewer slots than it needs.
    #[inline(always)]
    pub(super) fn new(needed: usize, factors: &'a [[u32; 2]], slots: &'a mut [[f64; N]]) -> Self {
        assert!(slots.len() >= needed);
        Lanes { slots: slots.as_mut_ptr(), factors: factors.as_ptr(), memory: PhantomData }
    }

    /// An operand of an instruction of the program.
    #[inline(always)]
    pub(super) fn read(&self, k: u32) -> &'a [f64; N] {
        // SAFETY: k is less than the number of slots (asserted by `Tape::compile` for every operand), of
        // which there are enough. Nothing writes there while the reference lives: it serves one instruction,
        // whose result is another slot (asserted by `Tape::compile`).
        unsafe { &*self.slots.add(k as usize) }
    }

    /// The result of an instruction of the program.
    #[inline(always)]
    #[allow(clippy::mut_from_ref)]
    pub(super) fn write(&self, k: u32) -> &'a mut [f64; N] {
        // SAFETY: as for `read`; the result of an instruction is no input and none of its operands (asserted
        // by `Tape::compile`).
        unsafe { &mut *self.slots.add(k as usize) }
    }

    /// The factors of a product in a chain of the program.
    #[inline(always)]
    pub(super) fn factors(&self, k: u32) -> [&'a [f64; N]; 2] {
        // SAFETY: every chain's pairs exist (asserted by `Tape::compile`).
        let [a, b] = unsafe { *self.factors.add(k as usize) };
        [self.read(a), self.read(b)]
    }
}
