#include "view/scene_run.h"

#include "feder/error.h"

namespace feder::view {
namespace {

const Kept* find_nth(const NamedStates& states, const ObjectView* view, const std::string& name, std::size_t n) {
  const auto own = states.find(view);
  if (own == states.end()) return nullptr;
  const auto found = own->second.find(name);
  return found != own->second.end() && n < found->second.size() ? &found->second[n] : nullptr;
}

// Calls f(view, id, name, n) for the named objects that can move: the n-th of its name.
template <class F>
void each_named(World& world, F&& f) {
  for (const ObjectView* view : object_views()) {
    std::map<std::string, std::size_t> seen;
    world.objects().for_each(view->kind(), [&](ObjectId id) {
      const std::string& name = world.objects().name(id);
      if (!name.empty() && view->keeps(world, id)) f(*view, id, name, seen[name]++);
    });
  }
}

}  // namespace

NamedStates named_states(World& world) {
  NamedStates s;
  each_named(world, [&](const ObjectView& view, ObjectId id, const std::string& name, std::size_t) {
    s[&view][name].push_back(view.state(world, id));
  });
  return s;
}

void apply_kept(World& world, const KeptState& kept) {
  each_named(world, [&](const ObjectView& view, ObjectId id, const std::string& name, std::size_t n) {
    const Kept* start = find_nth(kept.start, &view, name, n);
    const Kept* now = find_nth(kept.now, &view, name, n);
    if (start && now) view.apply(world, id, *start, *now);
  });
}

std::unique_ptr<SceneRun> SceneRun::make(const Recipe& recipe, LoadFailure& failure) {
  std::unique_ptr<SceneRun> run(new SceneRun);
  lua::HostOptions host = recipe.host;
  failure = {};
  try {
    run->script_ = std::make_unique<lua::Script>(std::move(host));
    run->script_->load_file(recipe.file);
    if (!run->script_->is_scene())
      throw lua::ScriptError(recipe.file.string() +
                             ": a plain script steps its world itself; the viewer shows scenes "
                             "(return feder.scene { ... })");
    run->script_->build();
    run->start_ = named_states(run->world());
    if (recipe.kept) apply_kept(run->world(), *recipe.kept);
    return run;
  } catch (const std::exception& e) {
    failure.message = e.what();
  }
  failure.files.push_back(std::filesystem::absolute(recipe.file).lexically_normal());
  if (run->script_)
    for (const auto& file : run->script_->files())
      if (file != failure.files[0]) failure.files.push_back(file);
  return nullptr;
}

void SceneRun::act(Command command) {
  deeds_.push_back({world().step_count(), command});
  command(*script_);
}

std::vector<Deed> SceneRun::deeds_before(std::uint64_t step) const {
  std::vector<Deed> some;
  std::copy_if(deeds_.begin(), deeds_.end(), std::back_inserter(some), [&](const Deed& d) { return d.step < step; });
  return some;
}

void SceneRun::do_due() {
  for (; next_due_ < due_.size() && due_[next_due_].step <= world().step_count(); ++next_due_) {
    try {
      act(due_[next_due_].command);
    } catch (const std::exception&) {
      // it failed the first time too
    }
  }
}

void SceneRun::step() {
  do_due();
  script_->step();
}

}  // namespace feder::view
