// Commands of collision detection.
#include "feder/query.h"
#include "record/commands.h"

namespace feder {

CommandRows record_collide() {
  return {command_row<&Collide::exclude>("collide.exclude"), command_row<&Collide::include>("collide.include"),
          command_row<&Collide::define_material>("collide.define_material"),
          command_row<&Collide::material>("collide.material"),
          command_row<&Collide::set_material_pair>("collide.set_material_pair")};
}

}  // namespace feder
