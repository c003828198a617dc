// Commands of cloth.
#include "feder/cloth.h"
#include "record/commands.h"

namespace feder {

CommandRows record_cloth() {
  return {command_row<&Cloth::add_cloth>("cloth.add_cloth"),
          command_row<&Cloth::destroy_cloth>("cloth.destroy_cloth"),
          command_row<&Cloth::set_point>("cloth.set_point"),
          command_row<&Cloth::set_velocity>("cloth.set_velocity"),
          command_row<&Cloth::apply_impulse>("cloth.apply_impulse"),
          command_row<&Cloth::pin>("cloth.pin"),
          command_row<&Cloth::unpin>("cloth.unpin"),
          command_row<&Cloth::set_script_force>("cloth.set_script_force"),
          command_row<&Cloth::clear_script_forces>("cloth.clear_script_forces"),
          command_row<&Cloth::wake>("cloth.wake"),
          command_row<&Cloth::sleep>("cloth.sleep"),
          command_row<&Cloth::attach>("cloth.attach"),
          command_row<&Cloth::detach>("cloth.detach"),
          command_row<&Cloth::detach_body>("cloth.detach_body")};
}

}  // namespace feder
