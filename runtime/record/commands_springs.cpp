// Commands of mass-spring nets.
#include "feder/net.h"
#include "record/commands.h"

namespace feder {

CommandRows record_springs() {
  return {command_row<&Springs::add_net>("springs.add_net"),
          command_row<&Springs::destroy_net>("springs.destroy_net"),
          command_row<&Springs::set_point>("springs.set_point"),
          command_row<&Springs::set_velocity>("springs.set_velocity"),
          command_row<&Springs::apply_impulse>("springs.apply_impulse"),
          command_row<&Springs::pin>("springs.pin"),
          command_row<&Springs::unpin>("springs.unpin"),
          command_row<&Springs::add_spring>("springs.add_spring"),
          command_row<&Springs::remove_spring>("springs.remove_spring"),
          command_row<&Springs::attach>("springs.attach"),
          command_row<&Springs::detach>("springs.detach"),
          command_row<&Springs::set_script_force>("springs.set_script_force"),
          command_row<&Springs::clear_script_forces>("springs.clear_script_forces")};
}

}  // namespace feder
