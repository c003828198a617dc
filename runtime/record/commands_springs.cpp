// Commands of mass-spring nets.
#include "feder/net.h"
#include "record/commands.h"

namespace feder {

CommandRows record_springs() {
  return {command_row<&Springs::add_net>("springs.add_net"),
          command_row<&Springs::destroy_net>("springs.destroy_net", kNetKind),
          command_row<&Springs::set_point>("springs.set_point", kNetKind),
          command_row<&Springs::set_velocity>("springs.set_velocity", kNetKind),
          command_row<&Springs::apply_impulse>("springs.apply_impulse", kNetKind),
          command_row<&Springs::pin>("springs.pin", kNetKind),
          command_row<&Springs::unpin>("springs.unpin", kNetKind),
          command_row<&Springs::add_spring>("springs.add_spring", kNetKind),
          command_row<&Springs::remove_spring>("springs.remove_spring", kNetKind),
          command_row<&Springs::attach>("springs.attach", kNetKind),
          command_row<&Springs::attach_point>("springs.attach_point", kNetKind),
          command_row<&Springs::detach>("springs.detach", kNetKind),
          command_row<&Springs::set_script_force>("springs.set_script_force", kNetKind),
          command_row<&Springs::clear_script_forces>("springs.clear_script_forces")};
}

}  // namespace feder
