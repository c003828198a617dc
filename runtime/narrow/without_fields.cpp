#include "narrow/field_tools.h"

namespace feder {
const FieldTools* field_tools() { return nullptr; }
}  // namespace feder
