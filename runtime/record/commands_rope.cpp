// Commands of ropes.
#include "feder/rope.h"
#include "record/commands.h"

namespace feder {

CommandRows record_rope() {
  return {command_row<&Rope::add_rope>("rope.add_rope"),
          command_row<&Rope::destroy_rope>("rope.destroy_rope", kRopeKind),
          command_row<&Rope::set_point>("rope.set_point", kRopeKind),
          command_row<&Rope::set_velocity>("rope.set_velocity", kRopeKind),
          command_row<&Rope::apply_impulse>("rope.apply_impulse", kRopeKind),
          command_row<&Rope::pin>("rope.pin", kRopeKind),
          command_row<&Rope::unpin>("rope.unpin", kRopeKind),
          command_row<&Rope::set_script_force>("rope.set_script_force", kRopeKind),
          command_row<&Rope::clear_script_forces>("rope.clear_script_forces"),
          command_row<&Rope::wake>("rope.wake", kRopeKind),
          command_row<&Rope::attach>("rope.attach", kRopeKind),
          command_row<&Rope::attach_point>("rope.attach_point", kRopeKind),
          command_row<&Rope::detach>("rope.detach", kRopeKind),
          command_row<&Rope::sleep>("rope.sleep", kRopeKind)};
}

}  // namespace feder
