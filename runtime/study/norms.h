// Error norms of a study, on plain numbers. Pure functions.
#pragma once
#include <span>

#include "feder/study.h"

namespace feder {

// Root mean square over points of the distance between two lists of points, three numbers each. NaN when sizes differ.
double rms_distance(std::span<const double> a, std::span<const double> b);

// Largest angle between orientations, 2 acos|q . q_ref|, rad; NaN without orientations.
double largest_angle(std::span<const double> q, std::span<const double> reference);

// min over components of -log10(|y - ref| / (1 + |ref|)) of x/x_scale and v/v_scale: correct digits, mixed (mescd of
// the IVP Test Set with atol = rtol). At most 17.
double correct_digits(const Observation& run, const Observation& reference, double x_scale, double v_scale);

// Cubic Hermite between (t0, a) and (t1, b) at t: positions and velocities; orientations from the nearer end.
void interpolate(double t0, const Observation& a, double t1, const Observation& b, double t, Observation& out);

// Least-squares straight line through (x, y): slope, intercept, rms residual. NaN with fewer than two points.
struct Line {
  double slope = NAN, intercept = NAN, rms = NAN;
};
Line fit_line(std::span<const double> x, std::span<const double> y);

}  // namespace feder
