// The tables of solvers of soft bodies and of laws of elasticity, from the lines that feder_variant(soft ...) wrote.
#include "feder/soft.h"
#include "soft/solver.h"

namespace feder {
using Row = Variant<SoftSolver>;
#include "soft_declare.inc"
using RowOflaws = ElasticLaw;
#include "soft_laws_declare.inc"

std::span<const Variant<SoftSolver>> soft_solvers() {
  static const std::initializer_list<Row> rows = {
#include "soft_rows.inc"
  };
  return {rows.begin(), rows.size()};
}

std::span<const ElasticLaw> elastic_laws() {
  static const std::initializer_list<ElasticLaw> rows = {
#include "soft_laws_rows.inc"
  };
  return {rows.begin(), rows.size()};
}

std::string default_elasticity() { return default_variant(elastic_laws(), "neo_hookean"); }
std::string default_soft_solver() { return default_variant(soft_solvers(), "xpbd"); }

}  // namespace feder
