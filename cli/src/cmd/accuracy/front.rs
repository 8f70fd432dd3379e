//! Which settings are worth their time: the Pareto front of error over cost, and what to recommend from it.
//!
//! A setting is on the front if nothing faster is as accurate. The knee is the point of the front that lies farthest below
//! the line from its fastest to its most accurate point, both scales logarithmic (Satopaa et al. 2011, "Kneedle", without
//! its smoothing): before it a little time buys much accuracy, after it much time buys little.

/// Cost (time, or bytes) and error of a setting, both above 0.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Point {
    pub cost: f64,
    pub error: f64,
}

/// Points of the front, by their places in `points`, the cheapest first. Noise must not make a step: of points within a
/// hundredth of an earlier one's error none is taken, and of those within three hundredths of each other's cost the last.
pub fn front(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<_> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        points[a].cost.total_cmp(&points[b].cost).then(points[a].error.total_cmp(&points[b].error)).then(a.cmp(&b))
    });
    let mut front: Vec<usize> = Vec::new();
    // What the cheapest of those cost that the last one stands for.
    let mut step = 0.0;
    for i in order {
        if front.last().is_none_or(|&last| points[i].error < 0.99 * points[last].error) {
            if points[i].cost < 1.03 * step {
                front.pop();
            } else {
                step = points[i].cost;
            }
            front.push(i);
        }
    }
    front
}

/// The place in `front` of its knee; 0 where it has fewer than three points.
pub fn knee(points: &[Point], front: &[usize]) -> usize {
    let at = |place: usize| {
        let Point { cost, error } = points[front[place]];
        [libm::log(cost), libm::log(error.max(1e-9))]
    };
    let (Some(last), true) = (front.len().checked_sub(1), front.len() >= 3) else { return 0 };
    let ([x0, y0], [x1, y1]) = (at(0), at(last));
    // On the line the parts of the way in time and in error are the same, below it error is ahead.
    let ahead = |place: usize| {
        let [x, y] = at(place);
        (y - y0) / (y1 - y0) - (x - x0) / (x1 - x0)
    };
    // The ends are on the line.
    (1..last).fold((0, 0.0), |best, place| if ahead(place) > best.1 { (place, ahead(place)) } else { best }).0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[[f64; 2]]) -> Vec<Point> {
        list.iter().map(|&[cost, error]| Point { cost, error }).collect()
    }

    #[test]
    fn fronts_leave_out_what_something_faster_beats() {
        let all = points(&[[10.0, 0.5], [1.0, 1.0], [5.0, 0.9], [5.0, 0.8], [20.0, 0.6], [30.0, 0.1], [40.0, 0.0999]]);
        assert_eq!(front(&all), [1, 3, 0, 5]);
        assert_eq!(front(&[]), [0usize; 0]);
        assert_eq!(front(&points(&[[1.0, 0.9], [1.02, 0.5], [2.0, 0.4]])), [1, 2]);
        // Many small steps: none of the front is lost for more than three hundredths of its cost.
        let steps: Vec<_> =
            (0..40).map(|i| Point { cost: 1.0 + 0.02 * f64::from(i), error: 1.0 / f64::from(1 + i) }).collect();
        let found = front(&steps);
        for p in &steps {
            assert!(found.iter().any(|&k| steps[k].cost <= 1.03 * p.cost && steps[k].error <= p.error / 0.99), "{p:?}");
        }
        // No point that is not on the front is better in both than any that is.
        for (i, p) in all.iter().enumerate() {
            assert!(front(&all).iter().all(|&k| k == i || !(p.cost < all[k].cost && p.error < 0.98 * all[k].error)));
        }
    }

    #[test]
    fn the_knee_is_where_steps_begin_to_bring_less() {
        let all = points(&[[1.0, 1.0], [2.0, 0.1], [100.0, 0.08], [1000.0, 0.05]]);
        assert_eq!(knee(&all, &front(&all)), 1);
        // Where all steps bring more and more, the fastest is as good a choice as any.
        let line = points(&[[1.0, 1.0], [10.0, 0.9], [100.0, 0.01]]);
        assert_eq!(knee(&line, &front(&line)), 0);
        assert_eq!(knee(&all[..2], &front(&all[..2])), 0);
    }
}
