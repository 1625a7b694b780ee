//! Connected components: parts of a machine that nothing couples, each computed on its own.

/// The components of a graph of `count` nodes with edges between pairs, ordered by their first
/// nodes. The nodes of a component are in ascending order.
pub fn components(count: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Vec<Vec<usize>> {
    let mut above: Vec<usize> = (0..count).collect();
    fn root(above: &mut [usize], mut node: usize) -> usize {
        while above[node] != node {
            above[node] = above[above[node]];
            node = above[node];
        }
        node
    }
    for (a, b) in pairs {
        let [a, b] = [a, b].map(|node| root(&mut above, node));
        // The first node of a component is its root.
        above[a.max(b)] = a.min(b);
    }
    let mut place = vec![usize::MAX; count];
    let mut all: Vec<Vec<usize>> = Vec::new();
    for node in 0..count {
        let own = root(&mut above, node);
        if own == node {
            place[node] = all.len();
            all.push(Vec::new());
        }
        all[place[own]].push(node);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::components;

    #[test]
    fn closed_form_components_are_named_by_their_first_nodes() {
        let found = components(7, [(5, 1), (4, 6), (1, 3), (6, 4), (3, 5)].into_iter());
        assert_eq!(found, [vec![0], vec![1, 3, 5], vec![2], vec![4, 6]]);
    }
}
