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
          command_row<&Fluid::destroy_fluid>("fluid.destroy_fluid", kFluidKind),
          command_row<&Fluid::set_velocities>("fluid.set_velocities", kFluidKind),
          command_row<&Fluid::set_interface>("fluid.set_interface", kFluidKind),
          command_row<&Fluid::wake>("fluid.wake", kFluidKind),
          command_row<&Fluid::set_script_forces>("fluid.set_script_forces", kFluidKind),
          command_row<&Fluid::clear_script_forces>("fluid.clear_script_forces"),
          command_row<&Fluid::add_emitter>("fluid.add_emitter", kFluidKind),
          command_row<&Fluid::add_drain>("fluid.add_drain", kFluidKind),
          command_row<&Fluid::destroy_emitter>("fluid.destroy_emitter", kEmitterKind),
          command_row<&Fluid::destroy_drain>("fluid.destroy_drain", kDrainKind),
          command_row<&Fluid::set_running>("fluid.set_running", kEmitterKind),
          command_row<&Fluid::aim>("fluid.aim", kEmitterKind),
          command_row<static_cast<FillShape>(&Fluid::fill)>("fluid.fill", kFluidKind),
          command_row<static_cast<FillPoints>(&Fluid::fill)>("fluid.fill_points", kFluidKind)};
}

}  // namespace feder
