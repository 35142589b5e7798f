//! Sums over blocks in one fixed order, in one process or many.
//!
//! Floating-point sums depend on their order. The blocks are the leaves of a binary tree: blocks
//! `2k` and `2k + 1` are added, then pairs of pairs, and so on. A process that has some of the blocks
//! forms every sum of the tree that needs no others and hands those on; a process with all of them gets
//! the root with the same bits as a process that had every block. A run of neighbouring blocks gives
//! at most two such sums for each level of the tree.

use serde::{Deserialize, Serialize};

use crate::error::LearnError;

/// A quantity that is added up over blocks.
pub(crate) trait Addend {
    /// Adds the sum over the blocks that follow.
    fn add(&mut self, following: Self);
}

impl Addend for Vec<f64> {
    fn add(&mut self, following: Self) {
        crate::product::add(self, &following);
    }
}

/// Sums that an update of the primitives needs, over some blocks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// Number of columns.
    pub count: usize,
    /// Squared Frobenius norm of the shifted data, where known, m².
    pub squared_norm_m2: f64,
    /// Squared Frobenius norm of the error, where known, m².
    pub squared_residual_m2: f64,
    /// Squared Frobenius norm of the error of left-out columns, m².
    pub left_out_residual_m2: f64,
    /// Sum of all activations, metres.
    pub activation_sum_m: f64,
    /// Sum of their squares, m².
    pub activation_squares_m2: f64,
    /// Products of activations `H Hᵀ` (rank x rank) of the columns that are learned from, m².
    pub activation_gram_m2: Vec<f64>,
    /// Products of activations and data `H Vᵀ` (rank x rows) of the same columns, m²; empty where it was not asked for.
    pub cross_m2: Vec<f64>,
}

impl Addend for Sums {
    fn add(&mut self, following: Self) {
        self.count += following.count;
        self.squared_norm_m2 += following.squared_norm_m2;
        self.squared_residual_m2 += following.squared_residual_m2;
        self.left_out_residual_m2 += following.left_out_residual_m2;
        self.activation_sum_m += following.activation_sum_m;
        self.activation_squares_m2 += following.activation_squares_m2;
        self.activation_gram_m2.add(following.activation_gram_m2);
        self.cross_m2.add(following.cross_m2);
    }
}

/// A sum over the blocks `index * 2^level .. (index + 1) * 2^level`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node<S = Sums> {
    /// Level in the tree: 0 for a single block.
    pub level: u32,
    /// Place in its level.
    pub index: usize,
    /// The sum.
    pub sum: S,
}

impl<S> Node<S> {
    /// First block of the sum.
    pub fn first_block(&self) -> usize {
        self.index << self.level
    }

    /// One past its last block.
    fn end_block(&self) -> usize {
        (self.index + 1) << self.level
    }
}

/// Sums over a run of neighbouring blocks, grown block by block.
#[derive(Clone, Debug)]
pub struct Tree<S = Sums> {
    nodes: Vec<Node<S>>,
}

impl<S> Default for Tree<S> {
    fn default() -> Self {
        Self { nodes: Vec::new() }
    }
}

#[expect(
    private_bounds,
    reason = "the sums of a round are the only ones outside this crate"
)]
impl<S: Addend> Tree<S> {
    /// Adds what follows the blocks that are there.
    ///
    /// # Errors
    ///
    /// [`LearnError::Data`] where it does not.
    pub fn push(&mut self, mut node: Node<S>) -> Result<(), LearnError> {
        if let Some(last) = self.nodes.last()
            && last.end_block() != node.first_block()
        {
            return Err(out_of_order(last.end_block(), node.first_block()));
        }
        while let Some(left) = self.nodes.pop_if(|left| {
            left.level == node.level && left.index % 2 == 0 && left.index + 1 == node.index
        }) {
            let mut sum = left.sum;
            sum.add(node.sum);
            node = Node {
                level: node.level + 1,
                index: node.index / 2,
                sum,
            };
        }
        self.nodes.push(node);
        Ok(())
    }

    /// Adds the sum of one block.
    ///
    /// # Errors
    ///
    /// As [`push`](Self::push).
    pub fn push_block(&mut self, block: usize, sum: S) -> Result<(), LearnError> {
        self.push(Node {
            level: 0,
            index: block,
            sum,
        })
    }

    /// The sums that need no other blocks, in order.
    pub fn into_nodes(self) -> Vec<Node<S>> {
        self.nodes
    }

    /// The sum over all blocks.
    ///
    /// # Errors
    ///
    /// [`LearnError::Data`] where it is not over the blocks `0..blocks`.
    pub fn root(mut self, blocks: usize) -> Result<S, LearnError> {
        let first = self.nodes.first().map(Node::first_block);
        let end = self.nodes.last().map(Node::end_block);
        let found = match (first, end) {
            (Some(0), Some(end)) => end,
            _ => 0,
        };
        let last = self.nodes.pop().filter(|_| found == blocks);
        let last = last.ok_or_else(|| out_of_order(blocks, found))?;
        // Where the number of blocks is no power of two, the last sums are on different levels.
        let mut total = last.sum;
        while let Some(left) = self.nodes.pop() {
            let mut sum = left.sum;
            sum.add(total);
            total = sum;
        }
        Ok(total)
    }
}

fn out_of_order(expected: usize, found: usize) -> LearnError {
    LearnError::Data(format!(
        "sums go on at block {found}, expected block {expected}: blocks are missing or there twice"
    ))
}

#[cfg(test)]
mod tests {
    use super::{Tree, out_of_order};

    fn value(block: usize) -> Vec<f64> {
        vec![
            (block as f64 * 0.7).sin() * 10_f64.powi(block as i32 % 9),
            1.0,
        ]
    }

    #[test]
    fn any_cut_into_runs_gives_the_same_bits() {
        for blocks in 1..70 {
            let mut whole = Tree::default();
            for block in 0..blocks {
                whole.push_block(block, value(block)).unwrap();
            }
            let whole = whole.root(blocks).unwrap();
            assert_eq!(whole[1], blocks as f64);
            for shards in 1..=blocks.min(9) {
                let mut merged = Tree::default();
                for shard in 0..shards {
                    let mut part = Tree::default();
                    for block in shard * blocks / shards..(shard + 1) * blocks / shards {
                        part.push_block(block, value(block)).unwrap();
                    }
                    let nodes = part.into_nodes();
                    assert!(nodes.len() <= 2 * 7);
                    for node in nodes {
                        merged.push(node).unwrap();
                    }
                }
                let merged = merged.root(blocks).unwrap();
                assert_eq!(merged[0].to_bits(), whole[0].to_bits(), "{blocks} {shards}");
            }
        }
    }

    #[test]
    fn blocks_that_are_missing_are_named() {
        let mut tree = Tree::default();
        tree.push_block(0, value(0)).unwrap();
        assert_eq!(tree.push_block(2, value(2)), Err(out_of_order(1, 2)));
        assert_eq!(tree.root(3), Err(out_of_order(3, 1)));
    }
}
