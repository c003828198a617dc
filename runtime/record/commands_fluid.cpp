// Commands of particle fluids.
#include "feder/fluid.h"
#include "record/commands.h"

namespace feder {
namespace {

using FillShape = std::size_t (Fluid::*)(ObjectId, const Shape&, const Pose&, const Vec3&);
using FillPoints = std::size_t (Fluid::*)(ObjectId, std::span<const Vec3>, const Vec3&);

}  // namespace

CommandRows record_fluid() {
  return {command_row<&Fluid::add_fluid>("fluid.add_fluid"),
          command_row<&Fluid::destroy_fluid>("fluid.destroy_fluid"),
          command_row<&Fluid::set_velocities>("fluid.set_velocities"),
          command_row<&Fluid::add_emitter>("fluid.add_emitter"),
          command_row<&Fluid::add_drain>("fluid.add_drain"),
          command_row<&Fluid::destroy_emitter>("fluid.destroy_emitter"),
          command_row<&Fluid::destroy_drain>("fluid.destroy_drain"),
          command_row<&Fluid::set_running>("fluid.set_running"),
          command_row<&Fluid::aim>("fluid.aim"),
          command_row<static_cast<FillShape>(&Fluid::fill)>("fluid.fill"),
          command_row<static_cast<FillPoints>(&Fluid::fill)>("fluid.fill_points")};
}

}  // namespace feder
