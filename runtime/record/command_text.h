// A recorded command as a line that a person reads.
#pragma once
#include <string>

#include "feder/object.h"
#include "state/command_codec.h"

namespace feder {

// "rigid.set_velocity body "crate", (0, 5, 0)": names of objects as they are now. Lists are cut off.
std::string command_text(const std::string& name, const std::string& signature, std::string_view arguments,
                         const Objects& objects);

}  // namespace feder
