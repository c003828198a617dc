// Words for the numbers of springs/advice.cpp.
#include "lua/advice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "lua/records.h"
#include "springs/springs.h"

namespace feder::lua {
namespace {

constexpr int kMostSubsteps = 200;  // beyond, an implicit method is cheaper

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
    const double count = std::ceil(a.h * a.frequency * substeps / (NetAdvice::kSafeReach * info.stability_limit));
    needed = count <= kMostSubsteps ? std::max(1, static_cast<int>(count)) : 0;
    return needed > 0 ? v.name : "";
  }
  return "";
}

void suggest(AdviceRow& row, int substeps) {
  const NetAdvice& a = row.numbers;
  row.integrator = a.integrator;
  row.substeps = substeps;
  if (a.stable) return;
  if (!a.never_stable && a.substeps > 0 && a.substeps <= kMostSubsteps) {
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
  const std::string who = row.object + " with " + a.integrator, hw = "h w up to " + number(a.reach);
  if (a.never_stable)
    return who + " blows up where nothing damps: the method has no stable step; " + remedy(row, substeps);
  if (!a.stable)
    return who + " may blow up: " + hw + ", the limit is " + number(m.stability_limit) + "; " + remedy(row, substeps);
  if (a.frequency == 0) return who + " has no springs that could be too stiff";
  if (m.adaptive)
    return who + " chooses its own steps, " + std::to_string(a.parts) +
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

std::vector<AdviceRow> advise(World& world) {
  std::vector<AdviceRow> rows;
  const Springs* springs = world.find<Springs>();
  if (!springs) return rows;
  const WorldDesc& d = world.desc();
  for (std::size_t k = 0; k < springs->net_count(); ++k) {
    AdviceRow row;
    const ObjectId id = springs->net_info(k).object;
    row.numbers = springs->advice(id, d.dt, d.substeps);
    const NetAdvice& a = row.numbers;
    row.object = world.objects().describe(id);
    row.verdict = a.never_stable ? "never stable" : a.stable ? "stable" : "unstable";
    row.error_class = a.method.adaptive ? "tolerance" : a.method.exact_linear ? "exact" : decade(a.error);
    suggest(row, d.substeps);
    row.text = sentence(row, d.substeps);
    rows.push_back(std::move(row));
  }
  return rows;
}

int feder_advise(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(test_class(L, 1, Class::world));
  if (!block) fail_here(L, "expected a world, got " + describe(L, 1));
  WorldRecord& r = *state(L).worlds[block->world];
  if (!r.world) fail_here(L, "the world is closed");
  const auto text = [L](const char* key, const std::string& value) {
    lua_pushlstring(L, value.data(), value.size());
    lua_setfield(L, -2, key);
  };
  const auto value = [L](const char* key, double x) {
    lua_pushnumber(L, x);
    lua_setfield(L, -2, key);
  };
  lua_newtable(L);
  lua_Integer count = 0;
  for (const AdviceRow& row : advise(*r.world)) {
    const NetAdvice& a = row.numbers;
    lua_newtable(L);
    push_handle(L, r, a.net);
    lua_setfield(L, -2, "object");
    text("text", row.text), text("verdict", row.verdict), text("method", a.integrator);
    text("integrator", row.integrator), text("error_class", row.error_class);
    value("limit", a.method.stability_limit), value("h", a.h), value("hw", a.reach);
    value("frequency", a.frequency), value("decay", a.decay), value("error", a.error);
    value("resolved_hertz", a.resolved / (2 * 3.14159265358979));
    lua_pushinteger(L, row.substeps);
    lua_setfield(L, -2, "substeps");
    lua_rawseti(L, -2, ++count);
  }
  return 1;
}

}  // namespace feder::lua
