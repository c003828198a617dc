// Commands of cloth.
#include "feder/body.h"
#include "feder/cloth.h"
#include "record/commands.h"

namespace feder {

CommandRows record_cloth() {
  return {command_row<&Cloth::add_cloth>("cloth.add_cloth"),
          command_row<&Cloth::destroy_cloth>("cloth.destroy_cloth", kClothKind),
          command_row<&Cloth::set_point>("cloth.set_point", kClothKind),
          command_row<&Cloth::set_pressure>("cloth.set_pressure", kClothKind),
          command_row<&Cloth::set_velocity>("cloth.set_velocity", kClothKind),
          command_row<&Cloth::apply_impulse>("cloth.apply_impulse", kClothKind),
          command_row<&Cloth::pin>("cloth.pin", kClothKind),
          command_row<&Cloth::unpin>("cloth.unpin", kClothKind),
          command_row<&Cloth::set_script_force>("cloth.set_script_force", kClothKind),
          command_row<&Cloth::clear_script_forces>("cloth.clear_script_forces"),
          command_row<&Cloth::wake>("cloth.wake", kClothKind),
          command_row<&Cloth::sleep>("cloth.sleep", kClothKind),
          command_row<&Cloth::attach>("cloth.attach", kClothKind),
          command_row<&Cloth::attach_point>("cloth.attach_point", kClothKind),
          command_row<&Cloth::detach>("cloth.detach", kClothKind),
          command_row<&Cloth::detach_body>("cloth.detach_body", kBodyKind)};
}

}  // namespace feder
