//! The view of node `v`: its samples, and for each the leaf it would reach below the left and below the right child.
//!
//! With these two leaves known, any new rule at `v`, the rest of the tree fixed, is judged by moving samples between
//! two slots of a tally; leaves take their best class each time. A leaf is seen as a split that sends all its samples
//! to the left of two new leaves.

use crate::gains::prices::Prices;
use crate::gains::tally::{Member, Tally, Worth};
use crate::tree::rule::Rule;
use crate::tree::state::State;
use octmip_check::problem::Problem;

/// The samples of a node and where they would go.
#[derive(Debug, Default)]
pub(crate) struct NodeView {
    /// The node.
    pub(crate) v: u32,
    /// Its samples, in no particular order; the other arrays follow it.
    pub(crate) samples: Vec<u32>,
    /// Class, weight and slots of each sample.
    pub(crate) members: Vec<Member>,
    /// Whether the sample goes left now.
    pub(crate) is_left: Vec<bool>,
    /// The leaf behind each slot; two new ones behind a leaf.
    leaves: Vec<u32>,
    n_left_slots: usize,
    is_leaf: bool,
}

impl NodeView {
    /// Look at node `v` of a state.
    pub(crate) fn look(&mut self, problem: &Problem, prices: &Prices, state: &State, v: u32) {
        self.v = v;
        self.is_leaf = state.is_leaf(v);
        self.samples = state.samples(v);
        let n = self.samples.len();
        if self.is_leaf {
            self.leaves = vec![v; 2];
            self.n_left_slots = 1;
            let member = |&i: &u32| Member { slots: [0, 1], weighed: prices.weighed(i) };
            self.members.clear();
            self.members.extend(self.samples.iter().map(member));
            self.is_left = vec![true; n];
            return;
        }
        let [left, right] = state.nodes[v as usize].children;
        self.leaves = state.leaves(left);
        self.n_left_slots = self.leaves.len();
        self.leaves.extend(state.leaves(right));
        self.fill_members(problem, prices, state, [left, right]);
        let rule = &state.nodes[v as usize].rule;
        self.is_left.clear();
        self.is_left.extend(self.samples.iter().map(|&i| rule.goes_left(problem, i)));
    }

    fn fill_members(&mut self, problem: &Problem, prices: &Prices, state: &State, children: [u32; 2]) {
        let mut slot_of_node = vec![0; state.nodes.len()];
        for (slot, &leaf) in self.leaves.iter().enumerate() {
            slot_of_node[leaf as usize] = slot as u32;
        }
        let member = |&i: &u32| {
            let slots = children.map(|child| slot_of_node[state.route(problem, child, i) as usize]);
            Member { slots, weighed: prices.weighed(i) }
        };
        self.members.clear();
        self.members.extend(self.samples.iter().map(member));
    }

    /// The same node seen by every `step`-th of its samples.
    pub(crate) fn every(&self, step: usize) -> Self {
        Self {
            v: self.v,
            samples: self.samples.iter().step_by(step).copied().collect(),
            members: self.members.iter().step_by(step).copied().collect(),
            is_left: self.is_left.iter().step_by(step).copied().collect(),
            leaves: self.leaves.clone(),
            ..*self
        }
    }

    /// Number of slots.
    pub(crate) fn n_slots(&self) -> usize {
        self.leaves.len()
    }

    /// Fill a tally with all samples on the sides given by position.
    pub(crate) fn fill(&self, tally: &mut Tally, is_left: impl Fn(usize) -> bool) {
        tally.clear(self.n_slots());
        for (j, member) in self.members.iter().enumerate() {
            tally.add(member.slots[usize::from(!is_left(j))], member.weighed);
        }
    }

    /// Worth of the present rule, of so many features, price of this one split included.
    pub(crate) fn present(&self, tally: &mut Tally, price: i64) -> Worth {
        self.fill(tally, |j| self.is_left[j]);
        Worth { gain: tally.total - price, purity: tally.purity() }
    }

    /// Give `v` a new rule in the state and send its samples where they now belong.
    pub(crate) fn apply(&self, problem: &Problem, state: &mut State, rule: Rule) {
        if self.is_leaf {
            state.split(problem, self.v, rule);
        } else {
            self.leaves.iter().for_each(|&leaf| state.nodes[leaf as usize].samples.clear());
            for (j, &i) in self.samples.iter().enumerate() {
                let slot = self.members[j].slots[usize::from(!rule.goes_left(problem, i))];
                state.nodes[self.leaves[slot as usize] as usize].samples.push(i);
            }
            state.nodes[self.v as usize].rule = rule;
        }
        state.remove_empty_sides(self.v);
    }

    /// Put the left (0) or right (1) child in the place of `v`, with all its samples.
    pub(crate) fn replace_by_child(&self, state: &mut State, side: usize) {
        self.leaves.iter().for_each(|&leaf| state.nodes[leaf as usize].samples.clear());
        for (member, &i) in self.members.iter().zip(&self.samples) {
            state.nodes[self.leaves[member.slots[side] as usize] as usize].samples.push(i);
        }
        state.promote(self.v, state.nodes[self.v as usize].children[side]);
        state.remove_empty_sides(self.v);
    }
}
