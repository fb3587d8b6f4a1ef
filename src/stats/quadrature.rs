//! Adaptive quadrature over rectangles, for densities with peaks.

/// Nodes and weights of the Gauss–Legendre rules on [−1, 1] (Abramowitz & Stegun 1964, table 25.4).
const GAUSS3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
const GAUSS5: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// A rectangle [x0, x1] × [y0, y1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

impl Rect {
    fn quarters(self) -> [Rect; 4] {
        let (mx, my) = (0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1]));
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        [
            Rect { x: [x0, mx], y: [y0, my] },
            Rect { x: [mx, x1], y: [y0, my] },
            Rect { x: [x0, mx], y: [my, y1] },
            Rect { x: [mx, x1], y: [my, y1] },
        ]
    }
}

/// How far [`integrate`] refines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refinement {
    /// Halvings of both sides that are always made: what is narrower than the nodes of these may be missed.
    pub(crate) min_depth: u32,
    /// Halvings of both sides at most.
    pub(crate) max_depth: u32,
    /// A rectangle whose two estimates differ by less is not split.
    pub(crate) absolute: f64,
    /// The same, as a share of the estimate.
    pub(crate) relative: f64,
}

/// ∫∫ f(x, y) dx dy over `rect`: products of 5-point Gauss rules, quartered where the 3-point rule disagrees.
pub(crate) fn integrate(f: &impl Fn(f64, f64) -> f64, rect: Rect, refinement: Refinement) -> f64 {
    descend(f, rect, refinement, 0)
}

fn descend(f: &impl Fn(f64, f64) -> f64, rect: Rect, refinement: Refinement, depth: u32) -> f64 {
    if depth >= refinement.min_depth {
        let fine = product_rule(f, rect, &GAUSS5);
        let coarse = product_rule(f, rect, &GAUSS3);
        let tolerance = refinement.absolute + refinement.relative * fine.abs();
        if depth >= refinement.max_depth || (fine - coarse).abs() <= tolerance || !fine.is_finite() {
            return fine;
        }
    }
    rect.quarters().into_iter().map(|r| descend(f, r, refinement, depth + 1)).sum()
}

fn product_rule(f: &impl Fn(f64, f64) -> f64, rect: Rect, rule: &[(f64, f64)]) -> f64 {
    let half = |[a, b]: [f64; 2]| (0.5 * (a + b), 0.5 * (b - a));
    let ((cx, hx), (cy, hy)) = (half(rect.x), half(rect.y));
    let mut sum = 0.0;
    for (x, wx) in rule {
        for (y, wy) in rule {
            sum += wx * wy * f(cx + hx * x, cy + hy * y);
        }
    }
    sum * hx * hy
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Refinement = Refinement { min_depth: 1, max_depth: 14, absolute: 1e-10, relative: 0.0 };

    #[test]
    fn a_narrow_gaussian_has_its_known_integral() {
        // ∫∫ exp(−r²/s²)/(π s²) over a square of 50 standard deviations is 1
        let s = 0.02;
        let f = |x: f64, y: f64| {
            let (x, y) = (x - 0.3, y - 0.45);
            (-(x * x + y * y) / (s * s)).exp() / (std::f64::consts::PI * s * s)
        };
        let whole = integrate(&f, Rect { x: [0.0, 1.0], y: [0.0, 1.0] }, FINE);
        assert!((whole - 1.0).abs() < 1e-7, "{whole}");
    }

    #[test]
    fn a_step_along_a_circle_gives_the_circle_its_area() {
        let f = |x: f64, y: f64| if x * x + y * y < 1.0 { 1.0 } else { 0.0 };
        // coarser starts may miss a corner that the arc cuts off
        let refinement = Refinement { min_depth: 5, max_depth: 9, ..FINE };
        let area = integrate(&f, Rect { x: [0.0, 1.0], y: [0.0, 1.0] }, refinement);
        assert!((area - std::f64::consts::FRAC_PI_4).abs() < 2e-5, "{area}");
    }
}
