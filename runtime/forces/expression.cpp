// Force by formulas: options x, y, z (a formula each, N, "0" when left out), every other option a parameter of them.
// Weak spot: interpreted, some nanoseconds per operation, and no potential, so energies leave it out.
#include "forces/expression.h"

#include <atomic>

#include "base/functions.h"
#include "feder/force.h"

namespace feder {
namespace {

// A value with its derivatives by three variables.
struct Dual {
  double v = 0, d[3] = {0, 0, 0};
};

double value_of(double a) { return a; }
double value_of(const Dual& a) { return a.v; }
void set(double& out, double value) { out = value; }
void set(Dual& out, double value) { out = {value, {0, 0, 0}}; }

// a := f(a) or f(a, b), given the value and the partial derivatives of f.
void chain(double& a, double value, double) { a = value; }
void chain(Dual& a, double value, double by_a) {
  a.v = value;
  for (double& d : a.d) d *= by_a;
}
void chain(double& a, double, double value, double, double) { a = value; }
void chain(Dual& a, const Dual& b, double value, double by_a, double by_b) {
  a.v = value;
  for (int k = 0; k < 3; ++k) a.d[k] = by_a * a.d[k] + by_b * b.d[k];
}

double whole(double a, int n) {
  double result = 1, base = a;
  for (int k = n < 0 ? -n : n; k > 0; k /= 2, base *= base)
    if (k % 2 == 1) result *= base;
  return n < 0 ? 1 / result : result;
}

// Slope of a^b by b; 0 where there is none.
double by_exponent(double a, double value) { return a > 0 ? value * natural_log(a) : 0; }

}  // namespace

template <class Number>
bool Expression::run(const Number* variables, Number& out) const {
  Number stack[kMaxDepth];
  int top = -1;
  bool good = true;
  for (const Instruction& i : program_) {
    if (i.op == Op::constant) {
      set(stack[++top], i.value);
      continue;
    }
    if (i.op == Op::variable) {
      stack[++top] = variables[i.at];
      continue;
    }
    if (i.op >= Op::add) --top;
    Number& a = stack[top];
    const double x = value_of(a);
    const Number& b = i.op >= Op::add ? stack[top + 1] : a;
    const double y = value_of(b);
    switch (i.op) {
      case Op::negate: chain(a, -x, -1); break;
      case Op::sine: chain(a, sin_cos_sin(x), sin_cos_cos(x)); break;
      case Op::cosine: chain(a, sin_cos_cos(x), -sin_cos_sin(x)); break;
      case Op::exponential: {
        const double e = exponential(x);
        chain(a, e, e);
        break;
      }
      case Op::logarithm:
        good = good && x > 0;
        chain(a, x > 0 ? natural_log(x) : 0, 1 / x);
        break;
      case Op::root: {
        good = good && x >= 0;
        const double r = x > 0 ? std::sqrt(x) : 0;
        chain(a, r, r > 0 ? 0.5 / r : 0);
        break;
      }
      case Op::absolute: chain(a, std::fabs(x), x < 0 ? -1 : x > 0 ? 1 : 0); break;
      case Op::whole_power: chain(a, whole(x, i.at), i.at == 0 ? 0 : i.at * whole(x, i.at - 1)); break;
      case Op::add: chain(a, b, x + y, 1, 1); break;
      case Op::subtract: chain(a, b, x - y, 1, -1); break;
      case Op::multiply: chain(a, b, x * y, y, x); break;
      case Op::divide: chain(a, b, x / y, 1 / y, -x / (y * y)); break;
      case Op::power: {
        const double p = power(x, y), slope = x != 0 ? y * p / x : y == 1 ? 1 : 0;
        chain(a, b, p, slope, by_exponent(x, p));
        break;
      }
      case Op::least: chain(a, b, x < y ? x : y, x < y, !(x < y)); break;
      case Op::largest: chain(a, b, x > y ? x : y, x > y, !(x > y)); break;
      case Op::constant:
      case Op::variable: break;
    }
    good = good && std::isfinite(value_of(a));
  }
  out = stack[0];
  return good;
}

bool Expression::value(const double (&variables)[kVariables], double& out) const {
  double result = 0;
  if (!run(variables, result)) return false;
  out = result;
  return true;
}

bool Expression::gradient(const double (&variables)[kVariables], int first, double (&out)[3]) const {
  Dual dual[kVariables], result;
  for (int k = 0; k < kVariables; ++k) dual[k].v = variables[k];
  for (int k = 0; k < 3; ++k) dual[first + k].d[k] = 1;
  if (!run(dual, result)) return false;
  for (const double d : result.d)
    if (!std::isfinite(d)) return false;
  for (int k = 0; k < 3; ++k) out[k] = result.d[k];
  return true;
}

namespace {

constexpr OptionRow kAxes[] = {{"x", "N"}, {"y", "N"}, {"z", "N"}};

class ExpressionForce final : public Force {
 public:
  explicit ExpressionForce(const Params& p) {
    const std::vector<Expression::Parameter> parameters = p.others(kAxes);
    for (const OptionRow& axis : kAxes) {
      const std::string text = p.text(axis, "0");
      try {
        parts_.emplace_back(text, parameters);
      } catch (const SceneError& e) {
        throw SceneError(std::string(axis.name) + ": " + e.what());
      }
    }
  }

  void add(const MassPoint* points, std::size_t count, double time, Vec3* out) const override {
    std::uint64_t missed = 0;
    for (std::size_t i = 0; i < count; ++i) {
      double variables[Expression::kVariables];
      fill(points[i], time, variables);
      for (int axis = 0; axis < 3; ++axis) {
        double f = 0;
        if (part(axis).value(variables, f) && std::fabs(f) < kLargest)
          out[i][axis] += static_cast<Real>(f);
        else
          ++missed;
      }
    }
    if (missed > 0) faults_.fetch_add(missed, std::memory_order_relaxed);
  }

  bool derivative(const MassPoint* points, std::size_t count, double time, bool by_velocity, Mat3* out) const override {
    for (std::size_t i = 0; i < count; ++i) {
      double variables[Expression::kVariables];
      fill(points[i], time, variables);
      for (int axis = 0; axis < 3; ++axis) {
        double slope[3];
        if (!part(axis).gradient(variables, by_velocity ? Expression::kVelocity : 0, slope)) continue;
        for (int k = 0; k < 3; ++k) out[i](axis, k) += static_cast<Real>(clamp_slope(slope[k]));
      }
    }
    return true;
  }

  bool depends_on_velocity() const override {
    for (const Expression& e : parts_)
      for (int k = 0; k < 3; ++k)
        if (e.uses(Expression::kVelocity + k)) return true;
    return false;
  }

  std::uint64_t faults() const override { return faults_.load(std::memory_order_relaxed); }

 private:
  static constexpr double kLargest = 1e30;  // N, and N/m: far from the largest float

  static double clamp_slope(double s) { return s < -kLargest ? -kLargest : s > kLargest ? kLargest : s; }
  static void fill(const MassPoint& p, double time, double (&v)[Expression::kVariables]) {
    for (int k = 0; k < 3; ++k) v[k] = p.position[k], v[Expression::kVelocity + k] = p.velocity[k];
    v[6] = p.mass, v[7] = time;
  }
  const Expression& part(int axis) const { return parts_[static_cast<std::size_t>(axis)]; }

  std::vector<Expression> parts_;                 // x, y, z
  mutable std::atomic<std::uint64_t> faults_{0};  // nets may run side by side
};

}  // namespace

Variant<Force> forces_expression() {
  return variant_of<Force, ExpressionForce>(
      "expression", "formulas of x y z vx vy vz m t: x, y, z (\"-k*x + a*cos(w*t)\"), and the values they name");
}

}  // namespace feder
