// Commands of the world itself, of its table of objects, and of its forces.
#include "record/commands.h"
#include "world/recorded_force.h"

namespace feder {
namespace {

// Answers what the host's force has answered, in the same order. What does not fit counts as 0, and is noticed behind
// the step.
class PlayedForce final : public Force {
 public:
  PlayedForce(ReplayState& state, int traits) : state_(state), traits_(traits) {}

  void add(const MassPoint*, std::size_t count, double, Vec3* out) const override {
    const double* numbers = take(3 * count);
    for (std::size_t i = 0; numbers && i < count; ++i)
      for (int k = 0; k < 3; ++k) out[i][k] += static_cast<Real>(*numbers++);
  }
  bool derivative(const MassPoint*, std::size_t count, double, bool, Mat3* out) const override {
    const double* known = take(1);
    if (!known || *known == 0) return false;
    const double* numbers = take(9 * count);
    for (std::size_t i = 0; numbers && i < count; ++i)
      for (int k = 0; k < 9; ++k) out[i](k / 3, k % 3) += static_cast<Real>(*numbers++);
    return true;
  }
  bool depends_on_velocity() const override { return (traits_ & kForceOfVelocity) != 0; }
  bool on_area() const override { return (traits_ & kForceOnArea) != 0; }
  bool on_stepping_thread() const override { return true; }

 private:
  const double* take(std::size_t count) const {
    if (state_.forces.size() - state_.next_force < count) {
      state_.forces_fit = false;
      return nullptr;
    }
    const double* at = state_.forces.data() + state_.next_force;
    state_.next_force += count;
    return at;
  }

  ReplayState& state_;
  int traits_;
};

void add_host_force(ReplayState& state, int traits, const ForceEntry& target, std::string name, TagMask tags) {
  ForceEntry entry = target;
  if (traits & kForceThere) entry.force = std::make_shared<PlayedForce>(state, traits);
  state.world->add_force(std::move(entry), std::move(name), tags);
}

void add_known_force(ReplayState& state, std::string_view kind, const Params& options, const ForceEntry& target,
                     std::string name, TagMask tags) {
  state.world->add_force(kind, options, target, std::move(name), tags);
}

// Ranks between steps are the last ones: they are counted from the end.
void prepare_rank(ReplayState& state, int from_end) {
  const int rank = kRankCount + from_end;
  if (rank < static_cast<int>(Rank::query_colliders) || rank >= kRankCount)
    throw SceneError("recording: a query of an unknown rank");
  state.world->prepare_queries(static_cast<Rank>(rank));
}

void set_tags(ReplayState& state, ObjectId id, TagMask tags) {
  if (!state.world->objects().alive(id)) throw SceneError("recording: it sets tags of what is not alive");
  state.world->objects().set_tags(id, tags);
}

void keep_image(ReplayState& state, std::uint64_t hash) {
  if (std::binary_search(state.restored.begin(), state.restored.end(), hash))
    state.images[hash] = state.world->snapshot();
}

void restore_image(ReplayState& state, std::uint64_t hash) {
  const auto image = state.images.find(hash);
  if (image == state.images.end()) throw SceneError("recording: it restores a snapshot that it has not taken");
  state.world->restore(image->second);
}

}  // namespace

CommandRows record_world() {
  return {command_row<&World::set_gravity>("world.set_gravity"),
          command_row<&World::need_system>("world.need_system"),
          command_row<&World::plan>("world.plan"),
          command_row<&prepare_rank>("world.prepare_queries"),
          command_row<&add_known_force>("world.add_force"),
          command_row<&add_host_force>("world.add_host_force"),
          command_row<&World::remove_force>("world.remove_force", kForceKind),
          command_row<&World::set_force_enabled>("world.set_force_enabled"),
          command_row<&keep_image>("world.snapshot"),
          command_row<&restore_image>("world.restore"),
          command_row<&set_tags>("objects.set_tags"),
          command_row<&Objects::tag_bit>("objects.tag_bit")};
}

}  // namespace feder
