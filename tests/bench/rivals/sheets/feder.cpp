// feder's cloth at default settings, as a host sees it: solver, solver substeps and what holds its strain are its own
// choice unless the settings name a number.
#include <feder/cloth.h>
#include <feder/systems.h>
#include <feder/world.h>

#include "sheet.h"

namespace rivals {
namespace {

const feder::SystemDescriptor* const kSystems[] = {&feder::surface_contact_system(), &feder::cloth_system()};

feder::WorldDesc describe(const SheetScene& scene) {
  feder::WorldDesc desc;
  desc.gravity = feder::Vec3(0, scene.gravity, 0);
  desc.dt = scene.dt;
  desc.sleeping = false;
  return desc;
}

class FederSheet final : public SheetEngine {
 public:
  FederSheet(const SheetScene& scene, const SheetSettings& settings)
      : world_(describe(scene), kSystems), cloth_(world_.need<feder::Cloth>()), n_(scene.side_vertices) {
    feder::ClothDesc desc;
    desc.nx = desc.ny = static_cast<std::uint32_t>(n_);
    desc.size[0] = desc.size[1] = scene.side;
    desc.pose.rotation = feder::from_axis_angle(feder::Vec3(1, 0, 0), feder::kPi / 2);
    desc.area_density = scene.area_density;
    desc.pin_names = {"top_left", "top_right"};
    desc.substeps = settings.substeps;
    desc.self_collision = settings.self;
    if (settings.iterations > 0) desc.solver_options.set("iterations", static_cast<double>(settings.iterations));
    iterations_ = settings.iterations > 0 ? settings.iterations : 1;
    id_ = cloth_.add_cloth(desc);
  }

  void frame() override { world_.step(); }

  // Links along rows, columns and both diagonals; a hinge at every inner edge of the triangles.
  Rows rows() const override {
    const long n = n_, cells = n - 1;
    return {2 * n * cells + 2 * cells * cells, 2 * cells * (n - 2) + cells * cells,
            static_cast<double>(iterations_) * cloth_.substeps(id_) * world_.desc().substeps};
  }

  void positions(std::vector<Vec>& out) const override {
    std::vector<feder::Vec3> x;
    cloth_.positions(id_, x);
    out.clear();
    for (const feder::Vec3& v : x)
      out.push_back({static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])});
  }

 private:
  feder::World world_;
  feder::Cloth& cloth_;
  int n_, iterations_ = 1;
  feder::ObjectId id_;
};

}  // namespace

const char* const kSheetEngineName = "feder";
std::unique_ptr<SheetEngine> make_sheet(const SheetScene& scene, const SheetSettings& settings) {
  return std::make_unique<FederSheet>(scene, settings);
}

}  // namespace rivals
