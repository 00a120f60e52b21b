//! A length of small intestine below the liver: winding loops side by side.

use super::primitive::Through;

/// Length of a triangle's side, m.
pub(super) const EDGE_M: f64 = 0.0042;

const RADIUS_M: f64 = 0.0115;
/// Coordinate y of the uppermost row, m.
const TOP_M: f64 = 0.152;
/// Distance from one row to the next, m.
const ROW_M: f64 = 0.0320;
const ROWS: usize = 4;
/// Points of a row.
const POINTS: usize = 8;
/// Half the length of a row, m.
const HALF_M: f64 = 0.076;

/// The centre line, from the right end of the uppermost row to the end of the lowest. Rows wave up
/// and down alike, so that neighbouring rows fit into each other. Rows bulge to the front in the
/// middle, and round bends join them.
pub(super) fn line() -> Vec<Through> {
    let mut line = Vec::new();
    for row in 0..ROWS {
        for i in 0..POINTS {
            let along = i as f64 / (POINTS - 1) as f64 * 2.0 - 1.0;
            let x = if row % 2 == 0 { along } else { -along } * HALF_M;
            let wave = libm::sin(95.0 * x + 0.8);
            let y = TOP_M - ROW_M * row as f64 + 0.0045 * wave;
            let z = -0.094
                + 0.020 * (1.0 - (x / HALF_M).powi(2))
                + 0.004 * libm::cos(61.0 * x + row as f64)
                + 0.006 * row as f64;
            let radius = RADIUS_M * (1.0 + 0.05 * libm::sin(150.0 * x + 2.0 * row as f64));
            line.push(([x - 0.012, y, z], radius));
        }
        if row + 1 < ROWS {
            let side = if row % 2 == 0 { 1.0 } else { -1.0 };
            let x = side * (HALF_M + 0.014);
            let y =
                TOP_M - ROW_M * (row as f64 + 0.5) + 0.0045 * libm::sin(95.0 * side * HALF_M + 0.8);
            line.push(([x - 0.012, y, -0.092 + 0.006 * row as f64], RADIUS_M));
        }
    }
    line
}
