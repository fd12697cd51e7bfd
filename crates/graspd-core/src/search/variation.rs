//! Variation operators that keep the number of contacts: Genetic Fix crossover and opposite-pair mutation.

use super::problem::{Grasp, SearchProblem};
use crate::random::Stream;

/// Mutants of one grasp that are tried for one that keeps the spacing.
const MUTANTS: usize = 8;

/// A bit position in which exactly one of two parents has a one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Opposite {
    position: u32,
    in_first: bool,
}

/// Crosses two grasps of n candidates between two random cuts.
pub(super) fn cross(first: &mut Grasp, second: &mut Grasp, n: usize, stream: &mut Stream) {
    let cuts = stream.subset(n + 1, 2);
    genetic_fix(first, second, cuts[0], cuts[1]);
}

/// A mutant of a grasp that keeps the spacing. `None` when eight tries found none.
pub(super) fn spaced_mutant(
    grasp: &Grasp,
    problem: &SearchProblem,
    stream: &mut Stream,
) -> Option<Grasp> {
    (0..MUTANTS).find_map(|_| {
        let mut mutant = grasp.clone();
        mutate(&mut mutant, problem.len(), stream);
        problem.keeps_spacing(&mutant).then_some(mutant)
    })
}

/// Crosses two parents between the cuts: bit positions `from..to` (Ngo & Li 1998; paper, §3.3.2 and
/// Fig. 5).
///
/// The positions in which the parents differ are walked in ascending order with a stack. One of the
/// same orientation as the top (the one-bit in the same parent) is pushed, as is any onto an empty
/// stack; otherwise both positions are exchanged between the parents and the top is popped. Each
/// exchange gives a one and takes a one, so both children keep their number of ones.
///
/// Parents are the ascending positions of their ones, so this takes O(m) and no bit string.
pub(super) fn genetic_fix(first: &mut Vec<u32>, second: &mut Vec<u32>, from: u32, to: u32) {
    let mut stack: Vec<Opposite> = Vec::new();
    let mut exchanged: Vec<Opposite> = Vec::new();
    for bit in opposites(first, second).filter(|bit| (from..to).contains(&bit.position)) {
        match stack.last() {
            Some(top) if top.in_first != bit.in_first => {
                exchanged.push(*top);
                exchanged.push(bit);
                stack.pop();
            }
            _ => stack.push(bit),
        }
    }
    if exchanged.is_empty() {
        return;
    }
    let goes_from_first = |position: &u32| exchange_of(&exchanged, *position) == Some(true);
    let goes_from_second = |position: &u32| exchange_of(&exchanged, *position) == Some(false);
    first.retain(|p| !goes_from_first(p));
    second.retain(|p| !goes_from_second(p));
    for bit in &exchanged {
        let receiver = if bit.in_first {
            &mut *second
        } else {
            &mut *first
        };
        receiver.push(bit.position);
    }
    first.sort_unstable();
    second.sort_unstable();
}

fn exchange_of(exchanged: &[Opposite], position: u32) -> Option<bool> {
    exchanged
        .iter()
        .find(|bit| bit.position == position)
        .map(|bit| bit.in_first)
}

/// The positions in which two ascending sets differ, ascending.
fn opposites(first: &[u32], second: &[u32]) -> impl Iterator<Item = Opposite> {
    let only = |these: &[u32], those: &[u32], in_first: bool| -> Vec<Opposite> {
        these
            .iter()
            .filter(|p| those.binary_search(p).is_err())
            .map(|&position| Opposite { position, in_first })
            .collect()
    };
    let mut all = only(first, second, true);
    all.extend(only(second, first, false));
    all.sort_unstable_by_key(|bit| bit.position);
    all.into_iter()
}

/// Exchanges a random one with a random zero of a string of `n` bits (paper, §3.3.2 c).
/// Does nothing when there is no zero.
pub(super) fn mutate(ones: &mut [u32], n: usize, stream: &mut Stream) {
    if ones.len() >= n {
        return;
    }
    let slot = stream.below(ones.len());
    // The zero of rank k: every one at or before it pushes it one position on.
    let mut zero = stream.below(n - ones.len()) as u32;
    for &one in ones.iter() {
        if one <= zero {
            zero += 1;
        }
    }
    ones[slot] = zero;
    ones.sort_unstable();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    fn bits(text: &str) -> Vec<u32> {
        let ones = text.bytes().enumerate().filter(|(_, b)| *b == b'1');
        ones.map(|(i, _)| i as u32).collect()
    }

    /// The definition in §3.3.2 on bit strings, as it stands there.
    fn on_bit_strings(a: &mut [bool], b: &mut [bool], from: usize, to: usize) {
        let mut stack: Vec<usize> = Vec::new();
        for j in from..to {
            if a[j] == b[j] {
                continue;
            }
            match stack.last() {
                Some(&top) if a[top] != a[j] => {
                    std::mem::swap(&mut a[j], &mut b[j]);
                    std::mem::swap(&mut a[top], &mut b[top]);
                    stack.pop();
                }
                _ => stack.push(j),
            }
        }
    }

    #[test]
    fn worked_example_in_the_manner_of_figure_5() {
        // Opposite pairs between the cuts: 1 (A), 2 (A), 4 (B), 5 (A), 7 (B), 8 (B). Stack: push 1,
        // push 2, 4 meets 2: exchange, push 5, 7 meets 5: exchange, 8 meets 1: exchange.
        let mut a = bits("0110010001");
        let mut b = bits("0000100110");
        b.push(9);
        genetic_fix(&mut a, &mut b, 0, 9);
        assert_eq!(a, bits("0000100111"));
        assert_eq!(b, bits("0110010001"));
        // With the cut before 7 only 2 and 4 change places; 1 and 5 stay on the stack.
        let mut a = bits("0110010001");
        let mut b = bits("0000100111");
        genetic_fix(&mut a, &mut b, 0, 7);
        assert_eq!(a, bits("0100110001"));
        assert_eq!(b, bits("0010000111"));
    }

    #[test]
    fn agrees_with_the_definition_on_bit_strings() {
        let mut stream = Stream::new(5, Purpose::Offspring, 0);
        for _ in 0..20_000 {
            let n = 8 + stream.below(60);
            let m = 1 + stream.below(7);
            let (mut a, mut b) = (stream.subset(n, m), stream.subset(n, m));
            let cuts = stream.subset(n + 1, 2);
            let as_bits =
                |ones: &[u32]| -> Vec<bool> { (0..n as u32).map(|i| ones.contains(&i)).collect() };
            let (mut bits_a, mut bits_b) = (as_bits(&a), as_bits(&b));
            on_bit_strings(&mut bits_a, &mut bits_b, cuts[0] as usize, cuts[1] as usize);
            genetic_fix(&mut a, &mut b, cuts[0], cuts[1]);
            assert_eq!(as_bits(&a), bits_a);
            assert_eq!(as_bits(&b), bits_b);
        }
    }

    #[test]
    fn a_million_operations_keep_the_cardinality() {
        let (n, m) = (300, 7);
        let mut stream = Stream::new(6, Purpose::Offspring, 0);
        let mut pool: Vec<Vec<u32>> = (0..16).map(|_| stream.subset(n, m)).collect();
        for _ in 0..1_000_000 {
            let pair = stream.subset(16, 2);
            let (i, j) = (pair[0] as usize, pair[1] as usize);
            let (head, tail) = pool.split_at_mut(j);
            let cuts = stream.subset(n + 1, 2);
            genetic_fix(&mut head[i], &mut tail[0], cuts[0], cuts[1]);
            mutate(&mut head[i], n, &mut stream);
            for ones in [&head[i], &tail[0]] {
                assert_eq!(ones.len(), m);
                assert!(ones.windows(2).all(|w| w[0] < w[1]) && (ones[m - 1] as usize) < n);
            }
        }
    }

    #[test]
    fn mutation_reaches_every_zero_and_spares_the_rest() {
        let mut stream = Stream::new(7, Purpose::Offspring, 0);
        let mut seen = [false; 8];
        for _ in 0..1000 {
            let mut ones = vec![1, 4, 5];
            mutate(&mut ones, 8, &mut stream);
            let new: Vec<u32> = ones
                .iter()
                .filter(|o| ![1, 4, 5].contains(*o))
                .copied()
                .collect();
            assert_eq!(new.len(), 1);
            seen[new[0] as usize] = true;
        }
        assert_eq!(seen, [true, false, true, true, false, false, true, true]);
        let mut full = vec![0, 1, 2];
        mutate(&mut full, 3, &mut stream);
        assert_eq!(full, [0, 1, 2]);
    }
}
