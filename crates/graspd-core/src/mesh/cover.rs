//! Which places of a surface are exposed, buried in matter, or enclosed in a cavity.
//!
//! Most triangles are as a whole one of these. A triangle that another part crosses is cut into pieces, each of which is.

use std::ops::Range;

use super::triangle;

/// What lies before a place of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Outside, open to the surroundings.
    Exposed,
    /// Matter of another part.
    Buried,
    /// Outside, but sealed in a cavity.
    Enclosed,
}

/// A part of a triangle, itself a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) triangle: u32,
    /// Each corner by its weights of the whole triangle's corners.
    pub(super) corners: [[f64; 3]; 3],
    pub(super) state: State,
}

/// The whole triangle as a piece of itself.
const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The state of every place of a surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Cover {
    /// Of each triangle that is in no pieces; empty when all are exposed.
    states: Vec<State>,
    /// Of the others, in the order of the triangles.
    pieces: Vec<Piece>,
}

impl Cover {
    /// All triangles exposed.
    pub(super) fn exposed(count: usize) -> Self {
        Self {
            states: vec![State::Exposed; count],
            pieces: Vec::new(),
        }
    }

    pub(super) fn set(&mut self, triangle: usize, state: State) {
        self.states[triangle] = state;
    }

    /// Cuts triangles into pieces, which come in the order of the triangles. Where all pieces of a triangle are in the
    /// same state it stays whole.
    pub(super) fn cut(&mut self, pieces: Vec<Piece>) {
        for group in pieces.chunk_by(|a, b| a.triangle == b.triangle) {
            let state = group[0].state;
            if group.iter().all(|piece| piece.state == state) {
                self.set(group[0].triangle as usize, state);
            } else {
                self.pieces.extend(group);
            }
        }
    }

    /// Whether every place is exposed.
    pub(super) fn is_trivial(&self) -> bool {
        self.pieces.is_empty() && self.states.iter().all(|state| *state == State::Exposed)
    }

    /// The state of a place, given by its triangle and the weights of the corners.
    pub(super) fn state(&self, triangle: usize, weights: &[f64; 3]) -> State {
        let pieces = self.pieces[self.pieces_of(triangle)].iter();
        let nearest = pieces.max_by(|a, b| a.holds(weights).total_cmp(&b.holds(weights)));
        match nearest {
            Some(piece) => piece.state,
            None => self.states.get(triangle).copied().unwrap_or(State::Exposed),
        }
    }

    /// The exposed parts of a triangle: pieces by their number, or `None` for the triangle itself when all of it is
    /// exposed.
    pub(super) fn exposed_parts(&self, triangle: usize) -> impl Iterator<Item = Option<u32>> + '_ {
        let pieces = self.pieces_of(triangle);
        let whole = pieces.is_empty() && self.state(triangle, &[1.0 / 3.0; 3]) == State::Exposed;
        let exposed = pieces.filter(|&n| self.pieces[n].state == State::Exposed);
        let whole = whole.then_some(None).into_iter();
        whole.chain(exposed.map(|n| Some(n as u32)))
    }

    /// The corners of a part of a triangle, each by its weights of the whole triangle's corners.
    pub(super) fn corners(&self, part: Option<u32>) -> [[f64; 3]; 3] {
        part.map_or(WHOLE, |n| self.pieces[n as usize].corners)
    }

    /// Weights of the whole triangle's corners at a place that is given by weights of the corners of a part of it.
    pub(super) fn of_whole(&self, part: Option<u32>, weights: [f64; 3]) -> [f64; 3] {
        if part.is_none() {
            return weights;
        }
        let corners = self.corners(part);
        let sum = |axis: usize| (0..3).map(|i| corners[i][axis] * weights[i]).sum::<f64>();
        triangle::normalized([sum(0), sum(1), sum(2)])
    }

    fn pieces_of(&self, triangle: usize) -> Range<usize> {
        let before = |piece: &Piece| (piece.triangle as usize) < triangle;
        let begin = self.pieces.partition_point(before);
        let of = |piece: &Piece| piece.triangle as usize == triangle;
        begin..begin + self.pieces[begin..].partition_point(of)
    }
}

impl Piece {
    /// The least of the weights that the corners of the piece have at a place: negative outside of it.
    fn holds(&self, weights: &[f64; 3]) -> f64 {
        // Weights of three are a point of a plane, which their first two locate.
        let [a, b, c] = self.corners.map(|corner| [corner[0], corner[1]]);
        let cross = |o: [f64; 2], p: [f64; 2], q: [f64; 2]| {
            (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])
        };
        let at = [weights[0], weights[1]];
        let whole = cross(a, b, c);
        if whole == 0.0 {
            return f64::NEG_INFINITY;
        }
        let [u, v, w] = [cross(b, c, at), cross(c, a, at), cross(a, b, at)].map(|x| x / whole);
        u.min(v).min(w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_the_state_of_its_piece() {
        let middle = [0.0, 0.5, 0.5];
        let piece = |corners, state| Piece {
            triangle: 1,
            corners,
            state,
        };
        let [a, b, c] = WHOLE;
        let mut cover = Cover::exposed(3);
        cover.set(2, State::Enclosed);
        cover.cut(vec![
            piece([a, b, middle], State::Buried),
            piece([a, middle, c], State::Exposed),
        ]);
        assert!(!cover.is_trivial());
        assert_eq!(cover.state(0, &middle), State::Exposed);
        assert_eq!(cover.state(1, &[0.2, 0.5, 0.3]), State::Buried);
        assert_eq!(cover.state(1, &[0.2, 0.3, 0.5]), State::Exposed);
        assert_eq!(cover.state(2, &middle), State::Enclosed);
        assert_eq!(cover.exposed_parts(0).collect::<Vec<_>>(), [None]);
        assert_eq!(cover.exposed_parts(1).collect::<Vec<_>>(), [Some(1)]);
        assert_eq!(cover.exposed_parts(2).count(), 0);
        assert_eq!(cover.corners(Some(1)), [a, middle, c]);
        let there = cover.of_whole(Some(1), [0.5, 0.5, 0.0]);
        assert_eq!(there, [0.5, 0.25, 0.25]);
    }
}
