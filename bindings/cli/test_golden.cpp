#include "cli/test_golden.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "report/output_file.h"

namespace feder::cli {
namespace {

using report::Json;
using report::TestFailure;
using report::TestResult;

constexpr const char* kSchema = "golden/2";
constexpr const char* kEnergies[] = {"kinetic energy", "potential energy", "elastic energy"};

// A quantity, where it differs most from the golden run, and by how much.
struct Difference {
  std::string quantity, unit;
  double tolerance = 0, largest = 0, time = 0;
  std::string object = {}, expected = {}, actual = {};
};

std::string numbers_text(const double* x, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += fmt::format("{}{:.6g}", i ? ", " : "", x[i]);
  return count == 1 ? text : "(" + text + ")";
}

double distance(const double* a, const double* b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

double angle(const double* a, const double* b) {
  double dot = 0;
  for (int k = 0; k < 4; ++k) dot += a[k] * b[k];
  return 2 * std::acos(std::min(1.0, std::abs(dot)));
}

class Comparison {
 public:
  Comparison(const lua::GoldenWish& wish, const std::vector<GoldenSample>& golden)
      : differences_{Difference{"position", " m", wish.position}, Difference{"rotation", " rad", wish.rotation},
                     Difference{"energy", " of the largest", wish.energy}},
        relative_(wish.relative) {
    for (const GoldenSample& s : golden) {
      for (const double e : s.energy) scale_ = std::max(scale_, std::abs(e));
      for (std::size_t i = 0; i < s.names.size(); ++i) starts_.try_emplace(s.names[i], s.poses.at(i));
    }
  }

  void compare(const GoldenSample& golden, const GoldenSample& now) {
    if (golden.hash == now.hash) return;
    for (std::size_t i = 0; i < golden.names.size(); ++i) {
      const std::string& name = golden.names[i];
      const auto at = static_cast<std::size_t>(std::ranges::find(now.names, name) - now.names.begin());
      if (at == now.names.size()) {
        first_ = first_ ? first_ : Difference{"object", "", 0, 0, now.time, name, "in the world", "gone"};
        continue;
      }
      compare_pose(name, now.time, golden.poses.at(i), now.poses[at]);
    }
    for (std::size_t k = 0; k < std::min<std::size_t>(3, std::min(golden.energy.size(), now.energy.size())); ++k)
      note(2, std::abs(now.energy[k] - golden.energy[k]) / (scale_ > 0 ? scale_ : 1), now.time, kEnergies[k],
           &golden.energy[k], &now.energy[k], 1);
  }

  // The first that is over its tolerance, in time.
  const std::optional<Difference>& first() const { return first_; }
  bool same() const {
    return !first_ && std::ranges::all_of(differences_, [](const Difference& d) { return d.object.empty(); });
  }
  std::string table() const {
    std::string text = "  quantity    largest difference  tolerance  at        object\n";
    for (const Difference& d : differences_)
      text += fmt::format("  {:<10}  {:<18.4g}  {:<9.4g}  {:<8}  {}\n", d.quantity, d.largest, d.tolerance,
                          d.object.empty() ? "" : fmt::format("{:.4g} s", d.time), d.object);
    return text;
  }

 private:
  void compare_pose(const std::string& name, double time, const std::vector<double>& golden,
                    const std::vector<double>& now) {
    const std::vector<double>& start = starts_.at(name);
    if (golden.size() < 3 || now.size() < 3 || start.size() < 3) return;
    const double way = distance(golden.data(), start.data());
    note(0, distance(golden.data(), now.data()), time, name, golden.data(), now.data(), 3, relative_ * way);
    if (golden.size() >= 7 && now.size() >= 7) note(1, angle(&golden[3], &now[3]), time, name, &golden[3], &now[3], 4);
  }

  // `more`: what the tolerance has on top.
  void note(std::size_t quantity, double value, double time, const std::string& object, const double* expected,
            const double* actual, std::size_t count, double more = 0) {
    Difference& d = differences_[quantity];
    const double tolerance = d.tolerance + more;
    // not a number is over every tolerance
    const bool fails = !(value <= tolerance) && !first_;
    if (value <= d.largest && !fails) return;
    Difference found = d;
    found.largest = value, found.time = time, found.object = object;
    found.expected = numbers_text(expected, count), found.actual = numbers_text(actual, count);
    if (!(value <= d.largest)) d = found;
    if (!fails) return;
    first_ = found;
    first_->tolerance = tolerance;
  }

  std::array<Difference, 3> differences_;
  double scale_ = 0, relative_;
  std::map<std::string, std::vector<double>> starts_;  // poses that objects began with
  std::optional<Difference> first_;
};

GoldenFile read_golden(const std::string& file) {
  const Json json = Json::parse(read_text(file), nullptr, false);
  try {
    if (json.at("schema") != kSchema) throw Failure(kFailed, "{}: another version of golden runs", file);
    GoldenFile golden;
    report::read_into(json.at("samples"), golden.samples);
    golden.hashes = json.at("hashes").get<std::vector<std::string>>();
    return golden;
  } catch (const Json::exception&) {
    throw Failure(kFailed, "{}: no golden run; --update-golden writes it anew", file);
  }
}

}  // namespace

GoldenRun::GoldenRun(Session& session) : session_(session), wish_(session.script().golden()) {
  every_ = std::max<std::uint64_t>(1, session.steps_for(wish_.every));
}

void GoldenRun::look() {
  const World& world = *session_.world();
  run_.hashes.push_back(fmt::format("{:016x}", world.hash()));
  if (world.step_count() % every_ != 0) return;
  const Energy e = world.energy();
  GoldenSample s{world.time(), run_.hashes.back(), {e.kinetic, e.potential, e.elastic}, {}, {}};
  for (const lua::ObjectSample& o : session_.script().sample()) {
    std::string name = o.name;
    for (int n = 2; std::ranges::find(s.names, name) != s.names.end(); ++n) name = fmt::format("{} ({})", o.name, n);
    s.names.push_back(name);
    s.poses.emplace_back(std::begin(o.position), std::end(o.position));
    if (o.turns) s.poses.back().insert(s.poses.back().end(), std::begin(o.rotation), std::end(o.rotation));
  }
  run_.samples.push_back(std::move(s));
}

std::string GoldenRun::file() const {
  return std::filesystem::path(session_.file()).replace_extension(".golden.json").string();
}

void GoldenRun::finish(bool update, TestResult& result) {
  std::error_code ignored;
  const bool exists = std::filesystem::exists(file(), ignored);
  if (!exists && !update) {
    result.failures.push_back({.message = "no golden run " + file() + "; --update-golden writes it"});
    return;
  }
  const GoldenFile golden = exists ? read_golden(file()) : run_;
  const std::size_t count = golden.samples.size(), own = run_.samples.size();
  Comparison comparison(wish_, golden.samples);
  for (std::size_t i = 0; i < std::min(count, own); ++i) comparison.compare(golden.samples[i], run_.samples[i]);
  const bool other_length = count != own;
  if (!comparison.same() || other_length) result.diff = comparison.table();
  if (update) {
    if (!exists || !comparison.same() || other_length) write(result);
    return;
  }
  if (other_length)
    result.failures.push_back({.message = fmt::format("the golden run has {} samples, this one has {}; --update-golden "
                                                      "writes it anew",
                                                      count, own)});
  if (!comparison.first()) return;
  const Difference& d = *comparison.first();
  const std::string subject = std::string_view(d.quantity) == "energy" ? d.object : d.quantity + " of " + d.object;
  TestFailure f{.message = fmt::format("not as in the golden run: {} is {:.4g}{} off from {:.4g} s on", subject,
                                       d.largest, d.unit, d.time)};
  const auto parted = std::ranges::mismatch(golden.hashes, run_.hashes);
  if (parted.in1 != golden.hashes.end())
    f.message += fmt::format("; the states part at step {}", parted.in1 - golden.hashes.begin());
  f.time = d.time, f.step = static_cast<int>(std::llround(d.time / session_.world()->desc().dt));
  f.object = d.object, f.expected = d.expected, f.actual = d.actual;
  f.delta = fmt::format("{:.4g}{}", d.largest, d.unit), f.tolerance = fmt::format("{:g}{}", d.tolerance, d.unit);
  result.failures.push_back(f);
}

void GoldenRun::write(TestResult& result) const {
  std::string text = fmt::format("{{\"schema\": \"{}\", \"samples\": [", kSchema);
  for (const GoldenSample& sample : run_.samples)
    text += (&sample == run_.samples.data() ? "\n" : ",\n") + report::written(sample).dump();
  text += "\n], \"hashes\": [";
  for (const std::string& hash : run_.hashes)
    text += fmt::format("{}\"{}\"", &hash == run_.hashes.data() ? "\n" : ",\n", hash);
  report::write_text(file(), text + "\n]}\n");
  result.notice = file() + " written";
}

}  // namespace feder::cli
