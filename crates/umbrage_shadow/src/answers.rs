//! Answers to the questions that plans end in.

use std::collections::BTreeMap;

/// Bytes of buffers that earlier plans of the same shadow [asked](crate::ShadowPlan::asks) about.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    bytes: BTreeMap<String, Vec<u8>>,
    questions: usize,
}

static NONE: Answers = Answers {
    bytes: BTreeMap::new(),
    questions: 0,
};

impl Answers {
    /// No answers: nothing was asked yet.
    pub fn none() -> &'static Self {
        &NONE
    }

    /// The bytes that a buffer held, as its shader lays them out; where it was asked about more than once, the last ones.
    /// None where it was not asked about.
    pub fn get(&self, buffer: &str) -> Option<&[u8]> {
        self.bytes.get(buffer).map(Vec::as_slice)
    }

    /// How many questions were answered.
    pub fn questions(&self) -> usize {
        self.questions
    }

    /// These, and the answer to one more question: what each of its buffers held.
    pub fn with(mut self, answer: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        self.bytes.extend(answer);
        self.questions += 1;
        self
    }
}
