// Problems of point masses and springs, run through a World by every integrator: the same force code as the library's.
// Private to the module.
#pragma once
#include "feder/net.h"
#include "study/integrator_problem.h"

namespace feder {

struct NetSpring {
  std::uint32_t i, j;
  double stiffness, rest_length;
};

// In double: the world gets it rounded to Real, the reference does not.
struct NetModel {
  std::vector<double> x, v;  // three per point
  std::vector<double> mass;  // kg
  std::vector<std::uint8_t> pinned;
  std::vector<NetSpring> springs;
  double gravity = 0;                   // downwards along y
  std::vector<std::uint32_t> observed;  // points the errors are measured on

  std::uint32_t add(double px, double py, double pz, double m, bool pin = false);
};

class NetProblem : public IntegratorProblem {
 public:
  NetProblem() : IntegratorProblem("net", 16, 1e-10) {}
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  void reference(double t, Observation& out) const override;

 protected:
  // Energy at the start, degrees of freedom; call when the model stands.
  void measure_model();
  // The model's motion by extrapolation in long double.
  void use_extrapolation();
  // Motion along one axis by linear modes: free points, in order, move by u from `rest`.
  void use_modes(int axis, const std::vector<double>& rest);  // again after a change of the start
  const LinearModes& modes() const { return *modes_; }

  NetModel model_;

 private:
  void by_modes(double t, Observation& out) const;
  std::unique_ptr<OdeReference> extrapolated_;
  std::unique_ptr<LinearModes> modes_;
  std::vector<std::uint32_t> moving_;
  std::vector<double> rest_;
  int axis_ = 0;
};

}  // namespace feder
