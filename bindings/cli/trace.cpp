#include "cli/trace.h"

#include <fnmatch.h>

#include <algorithm>

namespace feder::cli {
namespace {

constexpr const char* kFixed[] = {"step", "time [s]", "kinetic [J]", "potential [J]", "elastic [J]"};
constexpr const char* kBodyColumns[] = {"x [m]",      "y [m]",      "z [m]",     "qx",       "qy",
                                        "qz",         "qw",         "vx [m/s]",  "vy [m/s]", "vz [m/s]",
                                        "wx [rad/s]", "wy [rad/s]", "wz [rad/s]"};
// centre and velocity by mass, ends of the box, number of points
constexpr const char* kPointColumns[] = {"x [m]",     "y [m]",     "z [m]",     "vx [m/s]",  "vy [m/s]",
                                         "vz [m/s]",  "min_x [m]", "min_y [m]", "min_z [m]", "max_x [m]",
                                         "max_y [m]", "max_z [m]", "count"};

}  // namespace

Trace::Trace(const std::string& file, std::vector<std::string> names)
    : table_(file), names_(std::move(names)), found_(names_.size(), false) {
  for (const char* name : kFixed) table_.add_column(name);
}

void Trace::record(Session& session, World& world) {
  end_row(session);
  open_ = true;
  time_ = world.time();
  find_objects(world);
  const Energy e = world.energy();
  table_.set(0, world.step_count());
  const double numbers[] = {time_, e.kinetic, e.potential, e.elastic};
  for (std::size_t k = 0; k < std::size(numbers); ++k) table_.set(k + 1, numbers[k]);
  put_objects(world);
}

std::string Trace::close(Session& session) {
  end_row(session);
  table_.close();
  for (std::size_t k = 0; k < names_.size(); ++k)
    if (!found_[k])
      return fmt::format("--track: nothing with a place is called '{}'{}", names_[k],
                         did_you_mean("; ", names_[k], others_));
  return "";
}

void Trace::end_row(Session& session) {
  if (!open_) return;
  open_ = false;
  put_plots(session);
  table_.end_row();
}

// Each object is looked at once.
void Trace::find_objects(World& world) {
  if (world_ != &world) seen_.clear(), tracked_.clear();
  world_ = &world;
  for (const report::StateReader& reader : report::state_readers())
    world.objects().for_each(reader.kind, [&](ObjectId id) {
      if (seen_.size() <= id.slot) seen_.resize(id.slot + 1, 0);
      if (std::exchange(seen_[id.slot], id.generation + 1) != id.generation + 1) track(world, id);
    });
}

void Trace::track(World& world, ObjectId object) {
  const std::string& own = world.objects().name(object);
  const std::string name = own.empty() ? world.objects().describe(object) : own;
  bool wanted = false;
  for (std::size_t k = 0; k < names_.size(); ++k)
    if (names_[k] == name || fnmatch(names_[k].c_str(), name.c_str(), 0) == 0) wanted = found_[k] = true;
  if (!wanted) {
    if (!own.empty() && others_.size() < 1000) others_.push_back(own);
    return;
  }
  // several may have one name
  const int number = ++titles_[name];
  const std::string title = number == 1 ? name : fmt::format("{}#{}", name, number);
  const report::StateReader* reader = report::state_reader(world, object);
  std::size_t first = table_.size();
  for (const char* column : reader->rigid ? std::span<const char* const>(kBodyColumns) : kPointColumns)
    table_.add_column(title + "." + column);
  tracked_.push_back({object, reader, first});
}

void Trace::put_objects(World& world) {
  for (const Tracked& t : tracked_) {
    if (!world.objects().alive(t.object)) continue;
    std::size_t at = t.column;
    const auto put = [&](const auto&... values) { (table_.set(at++, values), ...); };
    const auto put_vector = [&](const auto& v) { put(v[0], v[1], v[2]); };
    state_.clear();
    t.reader->read(world, t.object, state_);
    if (t.reader->rigid) {
      const Quat& q = state_.pose.rotation;
      put_vector(state_.pose.position), put(q.x, q.y, q.z, q.w);
      put_vector(state_.velocity), put_vector(state_.angular_velocity);
    } else {
      table_.set(t.column + std::size(kPointColumns) - 1, state_.positions.size());
      if (state_.positions.empty()) continue;
      const report::PointSummary s = report::summarize_points(state_);
      for (const auto& v : {s.center, s.velocity, s.low, s.high}) put_vector(v);
    }
  }
}

// The last value of each name at the time of the row; some of the next step may be there already.
void Trace::put_plots(Session& session) {
  for (const lua::PlotSeries& p : session.script().plots()) {
    const auto [at, is_new] = plots_.try_emplace(p.name, 0);
    if (is_new) at->second = table_.add_column(p.name);
    const auto point = std::find_if(p.points.rbegin(), p.points.rend(), [&](const auto& x) { return x.time <= time_; });
    if (point != p.points.rend() && point->time == time_) table_.set(at->second, point->value);
  }
}

}  // namespace feder::cli
