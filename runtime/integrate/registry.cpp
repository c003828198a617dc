// The table of integrators, generated from the feder_variant(integrate ...) lines.
#include "feder/params.h"
#include "integrate/integrator.h"

namespace feder {

using Row = Variant<Integrator>;
#include "integrate_declare.inc"

std::span<const Variant<Integrator>> integrators() {
  static const std::initializer_list<Variant<Integrator>> table = {
#include "integrate_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::string default_integrator() { return default_variant(integrators(), "symplectic_euler"); }

}  // namespace feder
