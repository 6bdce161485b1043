//! Graph of a function's values and control flow, with an edge from each node to those that it depends on.

use std::collections::VecDeque;

use naga::Span;

use super::{Scope, What};

/// Index of a node.
pub(super) type Node = u32;

/// Node of values that are the same for all invocations: constants.
pub(super) const UNIFORM: Node = 0;
/// Node of the control flow at the function's start.
pub(super) const START: Node = 1;
/// Node of values that may differ within a workgroup, but not within a subgroup.
pub(super) const DIFFERS_IN_WORKGROUP: Node = 2;
/// Node of values that may differ between any invocations.
pub(super) const DIFFERS: Node = 3;
/// First of the parameters' nodes, two for each: its value and its contents.
const PARAMETERS: Node = 4;

/// Meaning of a node without edges.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaf {
    Start,
    /// Values that may differ within the scope.
    Differs(Scope),
    Value(usize),
    Contents(usize),
}

#[derive(Debug)]
pub(super) struct Graph {
    nodes: Vec<NodeData>,
    /// Target of each edge, and the index of the same node's next edge; 0 where there is none.
    edges: Vec<(Node, u32)>,
    leaves: Node,
}

#[derive(Debug)]
struct NodeData {
    first_edge: u32,
    what: What,
    /// Node from which this one was reached; itself for the first node, none for one that was not reached.
    from: Option<Node>,
}

impl Graph {
    pub(super) fn new(parameters: usize) -> Self {
        let mut graph = Self {
            nodes: Vec::new(),
            edges: vec![(UNIFORM, 0)],
            leaves: PARAMETERS + 2 * parameters as Node,
        };
        for _ in 0..graph.leaves {
            graph.node(What::Other);
        }
        graph
    }

    pub(super) fn value_of(parameter: usize) -> Node {
        PARAMETERS + 2 * parameter as Node
    }

    pub(super) fn contents_of(parameter: usize) -> Node {
        PARAMETERS + 2 * parameter as Node + 1
    }

    /// Adds a node.
    pub(super) fn node(&mut self, what: What) -> Node {
        let node = self.nodes.len() as Node;
        self.nodes.push(NodeData {
            first_edge: 0,
            what,
            from: None,
        });
        node
    }

    /// Adds a node that depends on `on`.
    pub(super) fn node_on(&mut self, what: What, on: impl IntoIterator<Item = Node>) -> Node {
        let node = self.node(what);
        for on in on {
            self.edge(node, on);
        }
        node
    }

    /// Makes `node` depend on `on`.
    pub(super) fn edge(&mut self, node: Node, on: Node) {
        if on == UNIFORM || on == node {
            return;
        }
        let data = &mut self.nodes[node as usize];
        let edge = self.edges.len() as u32;
        self.edges.push((on, data.first_edge));
        data.first_edge = edge;
    }

    pub(super) fn what(&self, node: Node) -> What {
        self.nodes[node as usize].what
    }

    pub(super) fn kind(&self, leaf: Node) -> Leaf {
        match leaf {
            START => Leaf::Start,
            DIFFERS_IN_WORKGROUP => Leaf::Differs(Scope::Workgroup),
            DIFFERS => Leaf::Differs(Scope::Subgroup),
            _ => {
                let index = leaf - PARAMETERS;
                match index % 2 {
                    0 => Leaf::Value((index / 2) as usize),
                    _ => Leaf::Contents((index / 2) as usize),
                }
            }
        }
    }

    /// Marks every node as not reached.
    pub(super) fn forget(&mut self) {
        for node in &mut self.nodes {
            node.from = None;
        }
    }

    /// Leaves that `start` depends on, by way of nodes that were not reached before, nearest first, each with the
    /// node that led to it.
    pub(super) fn leaves(&mut self, start: Node) -> Vec<(Node, Node)> {
        let mut leaves = Vec::new();
        if start == UNIFORM {
            return leaves;
        }
        if start < self.leaves {
            return vec![(start, start)];
        }
        let mut queue = VecDeque::new();
        if self.nodes[start as usize].from.is_none() {
            self.nodes[start as usize].from = Some(start);
            queue.push_back(start);
        }
        while let Some(node) = queue.pop_front() {
            let mut edge = self.nodes[node as usize].first_edge;
            while edge != 0 {
                let (on, next) = self.edges[edge as usize];
                edge = next;
                if on < self.leaves {
                    leaves.push((on, node));
                } else if self.nodes[on as usize].from.is_none() {
                    self.nodes[on as usize].from = Some(node);
                    queue.push_back(on);
                }
            }
        }
        leaves
    }

    /// Path to `node` from the node at which the search started.
    pub(super) fn path(&self, node: Node) -> Vec<What> {
        let mut path = Vec::new();
        let mut at = node;
        loop {
            path.push(self.what(at));
            match self.nodes[at as usize].from {
                Some(from) if from != at => at = from,
                _ => break,
            }
        }
        path.reverse();
        path
    }

    /// First branch on the path to `node`.
    pub(super) fn branch(&self, node: Node) -> Option<Span> {
        branch(&self.path(node))
    }
}

/// First branch on `path`.
pub(super) fn branch(path: &[What]) -> Option<Span> {
    path.iter().find_map(|what| match what {
        What::Branch(span) => Some(*span),
        _ => None,
    })
}
