// Commands of rigid bodies and joints.
#include "feder/rigid.h"
#include "record/commands.h"

namespace feder {

CommandRows record_rigid() {
  return {command_row<&Rigid::add_body>("rigid.add_body"),
          command_row<&Rigid::destroy_body>("rigid.destroy_body"),
          command_row<&Rigid::set_pose>("rigid.set_pose"),
          command_row<&Rigid::set_velocity>("rigid.set_velocity"),
          command_row<&Rigid::set_angular_velocity>("rigid.set_angular_velocity"),
          command_row<&Rigid::apply_force>("rigid.apply_force"),
          command_row<&Rigid::apply_torque>("rigid.apply_torque"),
          command_row<&Rigid::apply_impulse>("rigid.apply_impulse"),
          command_row<&Rigid::apply_angular_impulse>("rigid.apply_angular_impulse"),
          command_row<&Rigid::move_to>("rigid.move_to"),
          command_row<&Rigid::set_type>("rigid.set_type"),
          command_row<&Rigid::carve>("rigid.carve"),
          command_row<&Rigid::weld_on>("rigid.weld_on"),
          command_row<&Rigid::set_filter>("rigid.set_filter"),
          command_row<&Rigid::set_friction>("rigid.set_friction"),
          command_row<&Rigid::set_restitution>("rigid.set_restitution"),
          command_row<&Rigid::set_surface_velocity>("rigid.set_surface_velocity"),
          command_row<&Rigid::set_damping>("rigid.set_damping"),
          command_row<&Rigid::set_gravity_scale>("rigid.set_gravity_scale"),
          command_row<&Rigid::set_sensor>("rigid.set_sensor"),
          command_row<&Rigid::wake>("rigid.wake"),
          command_row<&Rigid::sleep>("rigid.sleep"),
          command_row<&Rigid::wake_all>("rigid.wake_all"),
          command_row<&Rigid::add_joint>("rigid.add_joint"),
          command_row<&Rigid::destroy_joint>("rigid.destroy_joint"),
          command_row<&Rigid::set_motor>("rigid.set_motor"),
          command_row<&Rigid::set_limits>("rigid.set_limits")};
}

}  // namespace feder
