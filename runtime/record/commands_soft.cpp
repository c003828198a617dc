// Commands of soft bodies.
#include "feder/soft.h"
#include "record/commands.h"

namespace feder {

CommandRows record_soft() {
  return {command_row<&Soft::add_soft>("soft.add_soft"),
          command_row<&Soft::destroy_soft>("soft.destroy_soft", kSoftKind),
          command_row<&Soft::set_point>("soft.set_point", kSoftKind),
          command_row<&Soft::set_velocity>("soft.set_velocity", kSoftKind),
          command_row<&Soft::apply_impulse>("soft.apply_impulse", kSoftKind),
          command_row<&Soft::pin>("soft.pin", kSoftKind),
          command_row<&Soft::unpin>("soft.unpin", kSoftKind),
          command_row<&Soft::set_script_force>("soft.set_script_force", kSoftKind),
          command_row<&Soft::clear_script_forces>("soft.clear_script_forces"),
          command_row<&Soft::wake>("soft.wake", kSoftKind),
          command_row<&Soft::attach>("soft.attach", kSoftKind),
          command_row<&Soft::attach_point>("soft.attach_point", kSoftKind),
          command_row<&Soft::detach>("soft.detach", kSoftKind),
          command_row<&Soft::sleep>("soft.sleep", kSoftKind)};
}

}  // namespace feder
