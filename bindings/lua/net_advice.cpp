// Words for the numbers of springs/advice.cpp.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "integrate/integrator.h"
#include "lua/springs_part.h"

namespace feder::lua {
namespace {

struct AdviceRow {
  NetAdvice numbers;
  std::string object;       // "net 'rope'"
  int substeps = 0;         // suggested; 0: those there are do
  std::string integrator;   // suggested
  std::string error_class;  // "1e-2": the decade above the error of the fastest mode per period; "exact", "tolerance"
};

constexpr int kMaxSubsteps = 200;  // beyond, an implicit method is cheaper

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

std::string decade(double error) {
  if (!(error > 0)) return "exact";
  const int power = std::max(-16, static_cast<int>(std::ceil(std::log10(error) - 1e-9)));
  return power >= 0 ? "1" : "1e" + std::to_string(power);
}

// The first of the methods that damp out what is too stiff, of the highest order among them.
std::string stiff_method() {
  std::string best;
  int order = 0;
  for (const Variant<Integrator>& v : integrators()) {
    Arena arena("advice");
    const IntegratorInfo info = v.make(arena, Params())->info();
    if (info.l_stable && info.order > order) best = v.name, order = info.order;
  }
  return best;
}

// The first symplectic method with one force evaluation per step, and the substeps that it needs.
std::string plain_method(const NetAdvice& a, int substeps, int& needed) {
  for (const Variant<Integrator>& v : integrators()) {
    Arena arena("advice");
    const IntegratorInfo info = v.make(arena, Params())->info();
    if (!info.symplectic || info.implicit || info.evals_per_step != 1) continue;
    const double count = std::ceil(a.h * a.frequency * substeps / (NetAdvice::kSafeShare * info.stability_limit));
    needed = count <= kMaxSubsteps ? std::max(1, static_cast<int>(count)) : 0;
    return needed > 0 ? v.name : "";
  }
  return "";
}

void suggest(AdviceRow& row, int substeps) {
  const NetAdvice& a = row.numbers;
  row.integrator = a.integrator;
  row.substeps = substeps;
  if (a.stable) return;
  if (!a.never_stable && a.substeps > 0 && a.substeps <= kMaxSubsteps) {
    row.substeps = a.substeps;
    return;
  }
  int needed = 0;
  const std::string plain = a.never_stable ? plain_method(a, substeps, needed) : "";
  const std::string other = plain.empty() ? stiff_method() : plain;
  if (other.empty()) return;
  row.integrator = other;
  if (!plain.empty()) row.substeps = std::max(needed, substeps);
}

std::string remedy(const AdviceRow& row, int substeps) {
  if (row.integrator == row.numbers.integrator) {
    const std::string other = stiff_method();
    return std::to_string(row.substeps) + " substeps are safe" + (other.empty() ? "" : ", or " + other + " as it is");
  }
  return "take " + row.integrator +
         (row.substeps == substeps ? "" : " with " + std::to_string(row.substeps) + " substeps");
}

std::string sentence(const AdviceRow& row, int substeps) {
  const NetAdvice& a = row.numbers;
  const IntegratorInfo& m = a.method;
  const std::string who = row.object + " with " + a.integrator, hw = "h w up to " + number(a.stability_number);
  if (a.never_stable)
    return who + " blows up where nothing damps: the method has no stable step; " + remedy(row, substeps);
  if (!a.stable)
    return who + " may blow up: " + hw + ", the limit is " + number(m.stability_limit) + "; " + remedy(row, substeps);
  if (a.frequency == 0) return who + " has no springs that could be too stiff";
  if (m.adaptive)
    return who + " chooses its own steps, " + std::to_string(a.solver_substeps) +
           " or more per substep: its tolerance is the error";
  std::string out =
      who + " is stable: " + hw + (std::isinf(m.stability_limit) ? ", no limit" : " of " + number(m.stability_limit));
  if (m.exact_linear) return out + "; linear forces are exact";
  out += row.error_class != "1" ? "; its fastest mode errs by about " + row.error_class + " per period"
         : m.l_stable           ? "; its fastest modes are damped out"
                                : "; its fastest modes are not followed closely";
  return out + ", motions up to " + number(a.resolved / (2 * 3.14159265358979)) + " Hz by less than " +
         number(100 * NetAdvice::kResolvedError) + " %";
}

}  // namespace

std::vector<Advice> advise_nets(World& world) {
  std::vector<Advice> rows;
  const Springs* springs = world.find<Springs>();
  if (!springs) return rows;
  const WorldDesc& d = world.desc();
  for (std::size_t k = 0; k < springs->net_count(); ++k) {
    AdviceRow row;
    const ObjectId id = springs->net_info(k).object;
    row.numbers = springs->advice(id, d.dt, d.substeps);
    const NetAdvice& a = row.numbers;
    row.object = world.objects().describe(id);
    const char* verdict = a.never_stable ? "never stable" : a.stable ? "stable" : "unstable";
    row.error_class = a.method.adaptive ? "tolerance" : a.method.exact_linear ? "exact" : decade(a.error);
    suggest(row, d.substeps);
    rows.push_back({id,
                    sentence(row, d.substeps),
                    {{"verdict", verdict},
                     {"method", a.integrator},
                     {"integrator", row.integrator},
                     {"error_class", row.error_class},
                     {"limit", a.method.stability_limit},
                     {"h", a.h},
                     {"hw", a.stability_number},
                     {"frequency", a.frequency},
                     {"decay", a.decay},
                     {"error", a.error},
                     {"resolved_hertz", a.resolved / (2 * 3.14159265358979)},
                     {"substeps", std::int64_t{row.substeps}}}});
  }
  return rows;
}

}  // namespace feder::lua
